"""Pictures of bodies in space with numpy and matplotlib alone; no graphics hardware is needed."""
