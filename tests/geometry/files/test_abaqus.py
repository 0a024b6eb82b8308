"""Abaqus files as Abaqus/CAE, Gmsh, CalculiX and people write them: nodes, parts, sets and surfaces come back."""

import os

import numpy as np
import pytest
from abaqus_files import CAE, ELEMENTS, EVERY, HIGH, LOW, NODES, PLACES, ROWS

from pellucid.geometry.files.abaqus import read_abaqus
from pellucid.geometry.files.contents import Damaged
from pellucid.geometry.files.read import states_of_files
from pellucid.geometry.solid_meshes.file import SolidFile
from pellucid.geometry.surfaces.file import SurfaceFile


def read(tmp_path, text, name="cube.inp"):
    path = tmp_path / name
    path.write_text(text)
    return read_abaqus(str(path))


def sets_of(contents):
    return {name: nodes.tolist() for name, nodes in contents.nodes_of_sets().items()}


@pytest.mark.parametrize(
    ("text", "sets"),
    [
        (NODES + ELEMENTS.replace("C3D4, ELSET", "C3D4,\n ELSET"), {"CONT": EVERY}),
        (NODES + ELEMENTS.replace("*ELEMENT", "* Element").replace("TYPE=C3D4", "type = c3d4h"), {"CONT": EVERY}),
        (
            "\n".join(["*Node, nset=LOW", *ROWS[:4], "*Node, nset=HIGH", *ROWS[4:], ""]) + ELEMENTS,
            {"LOW": LOW, "HIGH": HIGH, "CONT": EVERY},
        ),
        (
            NODES + ELEMENTS + "*NSET,NSET=A\n1,2\n*NSET,NSET=B\n3,4\n*NSET,NSET=AB\nA,b\n",
            {"A": [0, 1], "B": [2, 3], "AB": LOW},
        ),
        (NODES + ELEMENTS + "*NSET,NSET=A\n1,2\n*NSET,NSET=a\n3,4\n", {"A": LOW}),
        (NODES + ELEMENTS + "*ELSET,ELSET=Eall\nCONT\n*ELSET,ELSET=E1,GENERATE\n2,2\n", {"Eall": EVERY, "E1": [1, 2, 3, 6]}),
        (NODES + ELEMENTS + "*NSET,NSET=G,GENERATE\n1,8,3\n5,6\n", {"G": [0, 3, 4, 5, 6]}),
        (NODES + ELEMENTS + "*NSET,NSET=OF,ELSET=CONT\n", {"OF": EVERY}),
        (NODES + ELEMENTS + "*NSET,NSET=wide\n1, 2,\n3,\n**\n4\n", {"wide": LOW}),
        (NODES + ELEMENTS + "*SURFACE,NAME=S\nCONT,S1\n1,S2\n", {"S": list(range(7))}),
    ],
    ids=[
        "keyword goes on",
        "other case",
        "two blocks",
        "sets of sets",
        "again",
        "of elements",
        "ranges",
        "of a set",
        "wide",
        "S",
    ],
)
def test_nodes_and_sets_in_the_forms_that_programs_write(text, sets, tmp_path):
    contents = read(tmp_path, text)
    assert np.array_equal(contents.points, PLACES)
    assert [(block.kind, len(block.nodes)) for block in contents.blocks] == [("tetra", 5)]
    found = sets_of(contents)
    assert {name: found[name] for name in sets} == sets
    assert contents.notes == ()


def test_included_files_are_read_in_their_place(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "nodes.inp").write_text(NODES + "*INCLUDE, INPUT=parts/sets.inp\n")
    (tmp_path / "parts" / "sets.inp").write_text("*NSET, NSET=LOW, GENERATE\n1, 4\n")
    text = "*INCLUDE, INPUT=parts\\nodes.inp\n" + ELEMENTS
    assert sets_of(read(tmp_path, text)) == {"LOW": LOW, "CONT": EVERY}
    (tmp_path / "rows.txt").write_text("\n".join(ROWS))
    for text in ("*NODE, INPUT=rows.txt\n" + ELEMENTS, "*NODE\n*INCLUDE, INPUT=rows.txt\n" + ELEMENTS):
        assert np.array_equal(read(tmp_path, text).points, PLACES)
    source = SolidFile(path=str(tmp_path / "cube.inp"))
    before = states_of_files(source)
    assert len(before) == 2
    os.utime(tmp_path / "rows.txt", (1, 1))
    assert states_of_files(source) != before, "a change of an included file is one of the mesh"


def test_parts_of_an_assembly_are_placed_with_their_sets(tmp_path):
    contents = read(tmp_path, CAE)
    assert len(contents.points) == 16
    assert sum(len(block.nodes) for block in contents.blocks) == 10
    turned = np.array([(3 - y, x, z) for x, y, z in PLACES])
    assert contents.points[8:] == pytest.approx(turned, abs=1e-12)
    sets = sets_of(contents)
    assert sets["Set-1"] == [*LOW, *range(8, 12)]
    assert sets["PART-1-2.Set-1"] == [8, 9, 10, 11]
    assert sets["Top"] == [*HIGH, 12, 13, 14, 15]
    assert sets["some"] == [*LOW, 8]
    assert sets["Surf-1"] == [8, 9, 11]
    assert sets["Set 1"] == sorted([0, 1, 3, 4, 5, 6, 8, 9, 11, 12, 13, 14])


def test_reference_points_of_an_assembly_are_left_out_with_their_sets(tmp_path):
    text = CAE.replace("*End Assembly", "*Node\n 1, 9., 9., 9.\n*Nset, nset=RP-1\n 1,\n*Nset, nset=all\n 1, Top\n*End Assembly")
    contents = read(tmp_path, text)
    assert len(contents.points) == 16
    assert "RP-1" not in contents.node_sets
    assert contents.node_sets["all"].tolist() == contents.node_sets["Top"].tolist()
    [note] = contents.notes
    assert note == "nodes of the assembly that no element uses, such as reference points, were removed, with the sets `RP-1`"


def test_a_part_without_an_assembly_is_read_where_it_is(tmp_path):
    text = CAE[: CAE.index("*Assembly")]
    assert np.array_equal(read(tmp_path, text).points, PLACES)


def test_elements_over_several_lines_and_of_several_kinds(tmp_path):
    brick = f"*ELEMENT, TYPE=C3D20R\n1, 1, 2, 3, 4, 5, 6, 7, 8,\n{', '.join(map(str, range(9, 21)))}\n"
    nodes = NODES + "\n".join(f"{k}, 0.5, 0.5, 0.0{k}" for k in range(9, 21)) + "\n"
    beams = "*ELEMENT, TYPE=B31, ELSET=beams\n7, 1, 2, 99\n*ELEMENT, TYPE=SPRINGA\n8, 1, 2\n"
    contents = read(tmp_path, nodes + brick + beams + "*ELEMENT, TYPE=S4R, ELSET=lid\n9, 5, 6, 7, 8\n")
    assert [(block.kind, len(block.nodes)) for block in contents.blocks] == [("hexahedron20", 1), ("line", 1), ("quad", 1)]
    assert contents.notes == ("elements of type SPRINGA were not read: they are not mesh elements",)
    assert sets_of(contents)["lid"] == HIGH


def test_shells_are_a_surface_with_its_sides_and_edges(tmp_path):
    text = NODES + "*ELEMENT, TYPE=S3, ELSET=sheet\n1, 1, 2, 3\n2, 1, 3, 4\n*SURFACE, NAME=top\nsheet, SPOS\n"
    text += "*SURFACE, NAME=edge, TYPE=ELEMENT\n1, E1\n*SURFACE, NAME=open\nsheet, XYZ\n"
    path = tmp_path / "sheet.inp"
    path.write_text("\n".join(line for line in text.splitlines() if line not in ROWS[4:]) + "\n")
    with pytest.warns(UserWarning, match="the surface `open` was not read"):
        surface = SurfaceFile(path=str(path))
    sets = surface.sets()
    assert surface.mesh().triangles.tolist() == [[0, 1, 2], [0, 2, 3]]
    assert {name: nodes.tolist() for name, nodes in sets.items()} == {"top": LOW, "edge": [0, 1], "sheet": LOW}


def test_coordinates_of_other_systems(tmp_path):
    cylinder = (
        "*NODE, SYSTEM=C\n1, 2., 90., 5.\n*NODE\n2, 1., 2.\n*SYSTEM\n10., 0., 0., 10., 1., 0.\n*NODE\n3, 1., 0., 4.\n*SYSTEM\n"
    )
    contents = read(tmp_path, cylinder + "*NODE, SYSTEM=S\n4, 2., 0., 90.\n*ELEMENT, TYPE=S4\n1, 1, 2, 3, 4\n")
    assert contents.points == pytest.approx(np.array([(0, 2, 5), (1, 2, 0), (10, 1, 4), (0, 0, 2)]), abs=1e-12)


def test_sets_of_one_name_that_differ_are_told(tmp_path):
    contents = read(tmp_path, NODES + ELEMENTS + "*NSET, NSET=CONT\n1\n*NSET, NSET=X\nnowhere\n")
    assert sets_of(contents)["CONT"] == [0]
    assert contents.notes == (
        "the set `X` contains `nowhere`, which the file does not define",
        "the node set and the element set `CONT` differ: the node set was read",
    )


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("*INCLUDE, INPUT=none.inp\n", r"line 1 includes none.inp, but there is no such file in the folder of cube.inp"),
        ("*INCLUDE, INPUT=cube.inp\n", "line 1: cube.inp includes itself"),
        (NODES + "*NGEN\n1, 8\n", r"\*NGEN in line 10 generates nodes or elements, which is not supported: list them all"),
        (NODES + ELEMENTS.replace("5, 2, 4, 5, 7", "5, 2, 4, 5"), "has 3 nodes, but its type has 4"),
        (
            NODES + ELEMENTS.replace("5, 2, 4, 5, 7", "5, 2, 4, 5, 9"),
            r"node 9 of element 5 \(tetra\) is not defined: the file defines 8",
        ),
        (NODES + ELEMENTS.replace("5, 2, 4, 5, 7", "5, 2, 4, 5,"), "the last line of the elements after line 10 is incomplete"),
        (
            NODES.replace("1, 1, 1", "1, 1.2.3, 1") + ELEMENTS,
            "the nodes after line 1 contain `1.2.3` instead of a number",
        ),
        (NODES.replace("1, 1, 1", "1, x, 1") + ELEMENTS, "the nodes after line 1 contain a word instead of a number"),
        (NODES + ELEMENTS + "*NSET, NSET=A\nA\n", "the set A contains itself"),
        (NODES + ELEMENTS + "*NSET, NSET=A, GENERATE\n1, 8, 0\n", "the set A has a range with a step of 0"),
        ("*INSTANCE, NAME=I, PART=P\n", "line 1 refers to a part that the file does not define"),
    ],
)
def test_what_is_wrong_with_an_abaqus_file_is_named(text, reason, tmp_path):
    with pytest.raises(Damaged, match=reason):
        read(tmp_path, text)


def test_a_file_that_includes_itself_through_another_is_refused(tmp_path):
    (tmp_path / "inner.inp").write_text("*HEADING\n*INCLUDE, INPUT=cube.inp\n")
    with pytest.raises(Damaged, match=r"^line 2 of inner.inp: cube.inp includes itself through inner.inp$"):
        read(tmp_path, "*INCLUDE, INPUT=inner.inp\n")


@pytest.mark.parametrize(
    ("text", "remedy"),
    [
        ("*INCLUDE, INPUT=nowhere.inp\n", "copy nowhere.inp into the folder of cube.inp"),
        ("*INCLUDE, INPUT=cube.inp\n", "remove line 1, or include a different file in this line"),
        (
            NODES + ELEMENTS.replace("5, 2, 4, 5, 7", "5, 2, 4, 5, 9"),
            "add node 9 to the lines after .NODE, or remove element 5",
        ),
        (NODES + "\n1, 0, 0, 3\n" + ELEMENTS, "remove one of the two lines"),
    ],
)
def test_the_remedy_is_one_for_the_fault(text, remedy, tmp_path):
    path = tmp_path / "cube.inp"
    path.write_text(text)
    with pytest.raises(ValueError, match=f"; {remedy}"):
        SolidFile(path=str(path))


def test_a_node_that_is_defined_twice_is_refused_unless_it_stays_where_it_is(tmp_path):
    again = f"** a comment\n*NODE\n{ROWS[3]}\n{ROWS[6].split(',')[0]}, 5, 5, 5\n"
    number = int(ROWS[6].split(",")[0])
    with pytest.raises(Damaged, match=rf"^line 13 defines node {number} again, at a different position than line 8$"):
        read(tmp_path, NODES + again + ELEMENTS)
    assert np.array_equal(read(tmp_path, NODES + f"*NODE\n{ROWS[3]}\n" + ELEMENTS).points, PLACES)
    (tmp_path / "rows.inp").write_text(f"{ROWS[3]}\n{number}, 5, 5, 5\n")
    with pytest.raises(
        Damaged, match=rf"^line 2 of rows.inp defines node {number} again, at a different position than line 8$"
    ):
        read(tmp_path, NODES + "*NODE, INPUT=rows.inp\n" + ELEMENTS)


def test_elements_of_unknown_types_are_named_where_no_others_are(tmp_path):
    path = tmp_path / "foo.inp"
    path.write_text(NODES + ELEMENTS.replace("C3D4", "FOO99"))
    for source, needed in ((SurfaceFile, "no triangles"), (SolidFile, "no tetrahedra")):
        with pytest.raises(ValueError, match=f"{needed} .*: its elements have unsupported types: FOO99; save these"):
            source(path=str(path))
