"""Gmsh's formats 2, 4.0 and 4.1: groups come back whatever else a file holds, and what is damaged is named."""

import numpy as np
import pytest
from gmsh_files import NODES, gmsh_file

from pellucid.geometry.files.contents import Damaged
from pellucid.geometry.files.gmsh import is_gmsh, read_gmsh
from pellucid.geometry.solid_meshes.file import SolidFile

FORMS = [
    ("2.2", False, "<"),
    ("2.2", True, "<"),
    ("2.2", True, ">"),
    ("4.0", False, "<"),
    ("4.0", True, "<"),
    ("4.1", False, "<"),
]
FORMS += [("4.1", True, "<"), ("4.1", True, ">")]


@pytest.mark.parametrize("parametric", [False, True])
@pytest.mark.parametrize(("version", "binary", "order"), FORMS)
def test_groups_of_some_entities_beside_others_without(version, binary, order, parametric, tmp_path):
    data = gmsh_file(version, binary, order, parametric)
    assert is_gmsh(data)
    contents = read_gmsh(data)
    assert contents.format == f"Gmsh {version.replace('2.2', '2')}, {'binary' if binary else 'text'}"
    assert np.array_equal(contents.points, NODES)
    counts = {block.kind: len(block.nodes) for block in contents.blocks}
    assert counts == {"vertex": 1, "triangle": 4, "tetra": 5}, "an element of two groups is there once"
    path = tmp_path / "cube.msh"
    path.write_bytes(data)
    with pytest.warns(UserWarning, match="the physical groups `no curve`"):
        mesh = SolidFile(path=str(path)).mesh()
    assert mesh.volumes.sum() == pytest.approx(1.0, rel=1e-12)
    sets = {name: nodes.tolist() for name, nodes in mesh.sets.items()}
    assert sets == {"Fixed face": [0, 1, 2, 3], "body": list(range(8)), "all of it": list(range(8))}


def test_names_with_quotes_and_spaces():
    data = gmsh_file("4.1").replace(b'"body"', b'"the "inner" body"')
    assert "the " + '"inner"' + " body" in read_gmsh(data).cell_sets


def test_a_group_without_a_name_goes_by_its_number():
    data = gmsh_file("4.1").replace(b'2 7 "Fixed face"\n', b"").replace(b"$PhysicalNames\n4", b"$PhysicalNames\n3")
    assert "7" in read_gmsh(data).cell_sets


def test_a_group_with_a_negative_number_is_that_of_its_size():
    """Gmsh marks the orientation of an entity in its group by the sign."""
    data = gmsh_file("4.1")
    face = b"1 0.0 0.0 0.0 0.0 0.0 0.0 1 7 1"
    assert face in data
    assert len(np.concatenate(read_gmsh(data.replace(face, face.replace(b" 7 ", b" -7 "))).cell_sets["Fixed face"])) == 2


def test_entities_of_a_mesh_in_partitions():
    """Elements belong to entities of their own then, which have the groups."""
    text = gmsh_file("4.1").decode()
    start, end = text.index("$Entities"), text.index("$Nodes")
    entities = [
        "$PartitionedEntities",
        "2",
        "1",
        "9 2",
        "0 0 1 1",
        "1 2 1 1 2 0 0 0 1 1 1 1 7 0",
        "1 3 1 2 1 2 0 0 0 1 1 1 1 3 0",
    ]
    contents = read_gmsh((text[:start] + "\n".join([*entities, "$EndPartitionedEntities", ""]) + text[end:]).encode())
    assert {name: sum(map(len, parts)) for name, parts in contents.cell_sets.items()} == {"Fixed face": 2, "body": 5}


def test_centres_of_arcs_are_left_out_with_a_note():
    """`Mesh.SaveAll` writes points of the geometry that no element of the mesh uses."""
    text = (
        gmsh_file("2.2").decode().replace("$Nodes\n8", "$Nodes\n9").replace("3 0.0 0.0 0.0\n", "3 0.0 0.0 0.0\n999 5 5 5\n", 1)
    )
    text = text.replace("1 15 2 0 1 3\n", "1 15 2 8 1 999\n").replace("$PhysicalNames\n4", '$PhysicalNames\n5\n0 8 "centre"')
    contents = read_gmsh(text.encode())
    assert len(contents.points) == 8
    assert "centre" not in contents.cell_sets
    assert contents.notes[-1].endswith("; the sets `centre` were removed too")
    assert any("1 point of the geometry was removed" in note for note in contents.notes)


def test_groups_that_format_2_has_lost_are_told():
    text = gmsh_file("2.2").decode()
    lines = [line for line in text.splitlines() if " 4 2 4 1 " not in line]
    text = (
        "\n".join(lines)
        .replace(" 2 2 7 1 ", " 2 2 0 1 ")
        .replace(" 4 2 3 1 ", " 4 2 0 1 ")
        .replace("$Elements\n15", "$Elements\n10")
    )
    [note] = read_gmsh(text.encode()).notes
    assert "format 2 with `Mesh.SaveAll` stores no groups: write format 4.1" in note


def test_a_section_without_its_end_behind_the_mesh_is_told():
    data = gmsh_file("4.1").replace(b"$EndNodeData\n", b"")
    assert "its section $NodeData was not read, as the line $EndNodeData is missing" in read_gmsh(data).notes


@pytest.mark.parametrize(
    ("version", "old", "new", "reason"),
    [
        (
            "4.1",
            "4.1 0 8",
            "3 0 8",
            "format version 3 is not supported .supported: 1, 2, 4.0 and 4.1.: write it with `Mesh.MshFileVersion = 4.1`",
        ),
        ("4.1", "4.1 0 8", "4.1 0 9", "must have a version, 0 .text. or 1 .binary."),
        ("4.1", "$EndNodes", "", r"its section \$Nodes has no end"),
        ("4.1", "2 8 3 73", "2 8", r"\$Nodes"),
        ("4.1", "$Nodes\n2 8", "$Nodes\n900000000 8", r"\$Nodes has a count of 900000000, which exceeds the size of the file"),
        ("4.1", "3 13 23\n", "3 13 x\n", r"the numbers of \$Nodes contain a word that is not a whole number"),
        ("4.1", "\n2 1 2 2\n", "\n2 1 77 2\n", "it has an element of kind 77, which is not one of the"),
        ("4.1", "$EndElements", "1 2 3\n$EndElements", r"its section \$Elements has more entries than its stated count"),
        ("2.2", "$Nodes\n8", "$Nodes\n7", r"its section \$Nodes has more entries than its stated count"),
        ("2.2", " 4 2 3 1 3 13 33 43", " 4 2 3 1 3 13 33 44", r"\(tetra\) has node 44, which is not one of the 8 nodes"),
        ("2.2", "\n13 1.0", "\n3 1.0", "1 node numbers occur twice; the first is 3"),
        ("2.2", '2 7 "Fixed face"', "2 7 Fixed", r"line 1 of \$PhysicalNames must have a dimension, a number and a quoted"),
    ],
)
def test_what_is_wrong_with_a_gmsh_file_is_named(version, old, new, reason):
    text = gmsh_file(version).decode()
    assert old in text
    with pytest.raises(Damaged, match=reason):
        read_gmsh(text.replace(old, new, 1).encode())


@pytest.mark.parametrize(("version", "binary", "order"), FORMS)
def test_a_file_that_is_cut_off_is_refused(version, binary, order):
    data = gmsh_file(version, binary, order)
    end = data.index(b"$EndElements")
    for length in range(10, end, 37):
        with pytest.raises(
            Damaged,
            match=r"has no end|truncated|missing|does not have|must have|exceeds the size of the file|instead of|contain",
        ):
            read_gmsh(data[:length])
