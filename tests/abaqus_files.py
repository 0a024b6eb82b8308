"""Texts of Abaqus input files with a cube of five tetrahedra: a flat file, and an assembly as Abaqus/CAE writes it."""

PLACES = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
ROWS = [f"{k}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(PLACES, 1)]
NODES = "*NODE\n" + "\n".join(ROWS) + "\n"
CELLS = "1, 1, 2, 4, 5\n2, 2, 3, 4, 7\n3, 2, 5, 6, 7\n4, 4, 5, 7, 8\n5, 2, 4, 5, 7\n"
ELEMENTS = "*ELEMENT, TYPE=C3D4, ELSET=CONT\n" + CELLS
LOW, HIGH, EVERY = [0, 1, 2, 3], [4, 5, 6, 7], list(range(8))
CAE = f"""*Heading
** Job name: Job-1
*Part, name=Part-1
*Node
{chr(10).join(ROWS)}
*Element, type=C3D4
{CELLS}*Nset, nset=Set-1, generate
 1,  4,  1
*Elset, elset="Set 1"
 1, 3
*Solid Section, elset="Set 1", material=Rubber
,
*End Part
*Assembly, name=Assembly
*Instance, name=Part-1-1, part=Part-1
*End Instance
*Instance, name=Part-1-2, part=Part-1
 3., 0., 0.
 3., 0., 0., 3., 0., 1., 90.
*End Instance
*Nset, nset=Top, instance=Part-1-1
 5, 6, 7, 8
*Nset, nset=Top, instance=Part-1-2
 5, 6, 7, 8
*Nset, nset=some
 Part-1-2.1, Part-1-1.Set-1
*Elset, elset=_Surf-1_S1, internal, instance=Part-1-2
 1,
*Surface, type=ELEMENT, name=Surf-1
_Surf-1_S1, S1
*End Assembly
*Step
*Boundary
Top, 1, 1
*End Step
"""
