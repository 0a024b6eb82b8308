"""Pictures of bodies in space with numpy and matplotlib alone: they work on machines without any graphics."""
