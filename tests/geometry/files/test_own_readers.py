"""Readers of the package: what the formats allow is read, and what is damaged is named with its line or place."""

import numpy as np
import pytest
from vtp_files import vtp

from pellucid.geometry.files.contents import Damaged
from pellucid.geometry.files.gmsh import read_gmsh1
from pellucid.geometry.files.ply import read_ply
from pellucid.geometry.files.surface_formats import FACET, read_obj, read_off, read_stl
from pellucid.geometry.files.vtk_legacy import is_grid, read_grid
from pellucid.geometry.files.vtk_xml import lz4_block, read_vtp

SQUARE = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
VERTICES = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
SPIRAL = "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 1 3 0\nv 1 2 0\nv 3 2 0\nv 3 1 0\nv 0 1 0\n"
FACET_TEXT = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n"


def elements(contents):
    return {block.kind: block.nodes.tolist() for block in contents.blocks}


@pytest.mark.parametrize(
    ("faces", "found"),
    [
        ("f 1 2 3 4", {"quad": [[0, 1, 2, 3]]}),
        ("vt 0 0\nf 1/1 2/1 3/1 4/1", {"quad": [[0, 1, 2, 3]]}),
        ("vn 0 0 1\nf 1//1 2//1 3//1", {"triangle": [[0, 1, 2]]}),
        ("vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1", {"triangle": [[0, 1, 2]]}),
        ("f 1 2 3\nf -4 -2 -1", {"triangle": [[0, 1, 2], [0, 2, 3]]}),
        ("g lid\nusemtl red\ns off\nf 1 2 \\\n3 # a comment\nl 1 2", {"triangle": [[0, 1, 2]]}),
        ("v 0.5 2 0\nf 1 2 3 5 4", {"triangle": [[0, 1, 2], [0, 2, 4], [0, 4, 3]]}),
    ],
)
def test_faces_of_obj_in_all_their_forms(faces, found):
    contents = read_obj((VERTICES + faces).encode())
    assert elements(contents) == found
    assert np.array_equal(contents.points[:4], SQUARE)


def test_obj_with_colours_and_weights_at_vertices():
    assert np.array_equal(read_obj(b"v 1 2 3 0.5 0.5 1\nv 0 0 0 1\nv 1 0 0\nf 1 2 3").points[0], (1, 2, 3))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("v 0 0\n", "line 1 has 2 numbers instead of 3"),
        (VERTICES + "f 0 1 2", "line 5 has an invalid vertex number; vertices count from 1"),
        (VERTICES + "f -5 1 2", "line 5 has an invalid vertex number"),
        (VERTICES + "f 1 2", "line 5 has 2 corners, but at least 3 are needed"),
        (VERTICES + "f 1 b 2", "line 5 has a word instead of a whole number"),
        (VERTICES + "v 0.5 0.2 0\nf 1 2 3 4 5", ""),
        (
            "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 1 3 0\nv 1 2 0\nv 3 2 0\nv 3 1 0\nv 0 1 0\nf 1 2 3 4 5 6 7 8",
            "8 corners and is not convex",
        ),
        ("cstype bezier\n", "line 1 has a free-form curve or surface"),
    ],
)
def test_what_is_wrong_with_an_obj_file_is_named(text, reason):
    if reason:
        with pytest.raises(Damaged, match=reason):
            read_obj(text.encode())
    else:
        assert len(read_obj(text.encode()).blocks[0].nodes) == 3, "a polygon that one of its corners sees all of is cut there"


@pytest.mark.parametrize(
    "text",
    [
        "solid a\n" + FACET_TEXT + "endsolid a\n",
        "solid\n" + FACET_TEXT.replace("endloop", "end loop").replace("endfacet", "end facet") + "end solid",
        ("solid a\n" + FACET_TEXT + "endsolid a").upper(),
        "solid a\n" + FACET_TEXT.replace("\n", " ") + "\nendsolid",
        "solid a\n" + FACET_TEXT.replace("1 0 0", "1.0D0 0 0") + "endsolid",
        "solid a\r\n" + FACET_TEXT.replace("\n", "\r\n") + "endsolid a\r\n",
    ],
    ids=["plain", "end loop", "upper case", "one line", "Fortran", "Windows"],
)
def test_stl_text_in_all_its_forms(text):
    contents = read_stl(text.encode())
    assert contents.format == "STL, text"
    assert np.array_equal(contents.points, SQUARE[:3])
    assert contents.notes == ()


@pytest.mark.parametrize(
    "before",
    ["# exported by X\n", "; a remark\n\n", "// facet vertex 1 2 3\n", "\ufeff", "exported by X, 2024\nunits: mm\n"],
    ids=["hash", "semicolon", "slashes", "mark", "plain"],
)
def test_stl_text_behind_a_comment(before):
    text = before + "solid a\n" + FACET_TEXT + "# between\n" + "endsolid a\n"
    for data in (text.encode(), text.replace("solid a\n", "", 1).encode(), text.encode("utf-16"), text.encode("utf-16-be")):
        contents = read_stl(data)
        assert contents.format == "STL, text"
        assert np.array_equal(contents.points, SQUARE[:3])


def binary_stl(count=2, header=b"made by hand", there=2):
    facets = np.zeros(there, FACET)
    facets["corners"] = SQUARE[[[0, 1, 2], [0, 2, 3]]][:there]
    return header.ljust(80) + np.uint32(count).tobytes() + facets.tobytes()


def test_binary_stl_also_of_a_header_that_begins_with_solid():
    for header in (b"made by hand", b"solid of a program that should not"):
        contents = read_stl(binary_stl(header=header))
        assert contents.format == "STL, binary"
        assert np.array_equal(contents.points, SQUARE[[0, 1, 2, 0, 2, 3]])
    assert read_stl(binary_stl() + b"end").notes == ("3 bytes after the 2 facets that its header states were not read",)


@pytest.mark.parametrize("count", [0, 2**32 - 1])
def test_binary_stl_that_was_written_before_its_facets_were_counted(count):
    for header in (b"streamed", b"solid of a program that should not"):
        contents = read_stl(binary_stl(count=count, header=header))
        assert np.array_equal(contents.points, SQUARE[[0, 1, 2, 0, 2, 3]])
        assert contents.notes == (f"its header states {count} facets, but 2 follow; all of these were read",)
    assert read_stl(binary_stl(count=1)).notes == (
        "50 bytes after the 1 facets that its header states, as long as 1 facets, were not read",
    )


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"a poem", "not text with `facet` and `vertex` lines"),
        (b"solid as a rock\n" + 200 * b"-", "it contains no facets"),
        (binary_stl(count=4_000_000_000), "states 4000000000 facets, but 2 follow"),
        (("solid\n" + FACET_TEXT[:60]).encode(), "ends within a facet, in line 6"),
        (("solid\n" + FACET_TEXT.replace("endloop", "vertex 0 1 0\nendloop")).encode(), "ends in line 8 has 4 corners, not 3"),
    ],
    ids=["poem", "rock", "count", "cut", "four corners"],
)
def test_what_is_wrong_with_an_stl_file_is_named(data, reason):
    with pytest.raises(Damaged, match=reason):
        read_stl(data)


def test_stl_without_its_end_is_read_with_a_note():
    assert read_stl(("solid\n" + FACET_TEXT).encode()).notes == ("the final `endsolid` is missing; the file may be truncated",)


PLY = """ply
format ascii 1.0
comment by hand
element vertex 5
property float x
property float y
property float z
property uchar red
element face 2
property list uchar int vertex_index
element edge 1
property int vertex1
property int vertex2
end_header
0 0 0 9
1 0 0 9
1 1 0 9
0 1 0 9
0.5 2 0 9
4 0 1 2 3
3 3 2 4
0 1
"""
MIXED = {"quad": [[0, 1, 2, 3]], "triangle": [[3, 2, 4]]}


def test_ply_text_keeps_quadrilaterals_beside_other_elements():
    contents = read_ply(PLY.encode())
    assert elements(contents) == MIXED
    assert np.array_equal(contents.points[:4], SQUARE)


STRIPS = (
    PLY[: PLY.index("element face")]
    + """element tristrips 1
property list int int vertex_indices
element material 1
property list uchar uchar vertex_index
end_header
"""
    + PLY[PLY.index("0 0 0 9") : PLY.index("4 0 1 2 3")]
)


@pytest.mark.parametrize(
    ("row", "found"),
    [
        ("4 0 1 3 2", [[0, 1, 3], [3, 1, 2]]),
        ("8 0 1 3 -1 3 2 4 -1", [[0, 1, 3], [3, 2, 4]]),
        ("6 0 1 3 3 2 4", [[0, 1, 3], [2, 3, 4]]),
    ],
    ids=["one", "two", "joined"],
)
def test_strips_of_triangles_of_ply(row, found):
    contents = read_ply((STRIPS + f"{row}\n1 2\n").encode())
    assert elements(contents) == {"triangle": found}
    assert contents.notes == ("1 rows of `material`, which have lists of vertices, were not read",)
    fan = (STRIPS + "4 0 1 2 3\n1 2\n").replace("tristrips", "trifans")
    assert elements(read_ply(fan.encode())) == {"triangle": [[0, 1, 2], [0, 2, 3]]}


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize("mixed", [True, False])
def test_binary_ply_of_both_orders_of_bytes(order, mixed):
    name = "little" if order == "<" else "big"
    faces = [[0, 1, 2, 3], [3, 2, 4]] if mixed else [[0, 1, 2], [0, 2, 3]]
    head = PLY[: PLY.index("end_header")].replace("ascii", f"binary_{name}_endian").replace("element edge 1", "element edge 0")
    data = f"{head}end_header\n".encode()
    for place in (*SQUARE, (0.5, 2, 0)):
        data += np.array(place, f"{order}f4").tobytes() + b"\x09"
    for face in faces:
        data += bytes([len(face)]) + np.array(face, f"{order}i4").tobytes()
    contents = read_ply(data)
    assert elements(contents) == (MIXED if mixed else {"triangle": faces})
    assert np.array_equal(contents.points[:4], SQUARE)
    with pytest.raises(Damaged, match="it ends before its last element"):
        read_ply(data[:-3])


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("vertex 5", "vertex 500000000000", "states 500000000000 of `vertex`, which exceeds the size of the file"),
        ("property float z", "property quad z", "header has a property that is not part of the PLY format"),
        ("property float z\n", "", "no x, y and z|not a whole number|negative length"),
        ("end_header", "end", "no header from `ply` to `end_header`"),
        ("format ascii 1.0\n", "", "does not define the format"),
        ("4 0 1 2 3", "-4 0 1 2 3", "a list of negative length"),
        ("0.5 2 0 9", "0.5 x 0 9", "its values contain a word instead of a number"),
        ("0.5 2 0 9", "0,5 2 0 9", "contain `0,5`, with a decimal comma, instead of a number"),
    ],
)
def test_what_is_wrong_with_a_ply_file_is_named(old, new, reason):
    with pytest.raises(Damaged, match=reason):
        read_ply(PLY.replace(old, new, 1).encode())


GMSH_1 = """$NOD
5
7 0 0 0
3 1 0 0
4 0 1 0
9 0 0 1
20 5 5 5
$ENDNOD
$ELM
3
1 4 12 1 4 7 3 4 9
2 2 0 1 3 7 3 4
3 15 0 1 1 20
$ENDELM
"""


def test_the_first_format_of_gmsh():
    contents = read_gmsh1(GMSH_1.encode())
    assert elements(contents) == {"tetra": [[0, 1, 2, 3]], "triangle": [[0, 1, 2]], "vertex": []}
    assert {name: [part.tolist() for part in parts] for name, parts in contents.cell_sets.items()} == {"12": [[0], [], []]}
    assert len(contents.points) == 4
    assert contents.notes[0].startswith("1 point of the geometry was removed")


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("$NOD\n5", "$NOD\n6", "node count is 6, but 5 lines"),
        ("$ELM\n3", "$ELM\n4", "element count is 4, but it has 3"),
        ("7 3 4 9", "7 3 4 8", "element 0 .counted from 0. has a corner that is not a node of the file"),
        ("3 1 0 0", "7 1 0 0", "1 node numbers occur twice"),
        ("1 4 12 1 4 7", "1 99 12 1 4 7", "has kind 99"),
        ("2 2 0 1 3 7", "2 2 0 1 900 7", "element 1 .counted from 0. is incomplete"),
        ("$ENDELM", "", "no section from \\$ELM to \\$ENDELM"),
    ],
)
def test_what_is_wrong_with_a_gmsh_1_file_is_named(old, new, reason):
    with pytest.raises(Damaged, match=reason):
        read_gmsh1(GMSH_1.replace(old, new, 1).encode())


POLYDATA = """# vtk DataFile Version 3.0
by hand
ASCII
DATASET POLYDATA
POINTS 5 float
0 0 0 1 0 0 1 1 0
0 1 0 0.5 2 0
METADATA
INFORMATION 0

VERTICES 1 2
1 0
POLYGONS 2 9
4 0 1 2 3
3 3 2 4
POINT_DATA 5
SCALARS s float
LOOKUP_TABLE default
1 2 3 4 5
"""
NEW_LISTS = "OFFSETS vtktypeint64\n0 4 7\nCONNECTIVITY vtktypeint64\n0 1 2 3\n3 2 4\n"


def test_vtk_polydata_of_old_and_new_versions():
    new = POLYDATA.replace("4 0 1 2 3\n3 3 2 4\n", NEW_LISTS).replace("VERTICES 1 2\n1 0\n", "")
    new = new.replace("Version 3.0", "Version 5.1").replace("POLYGONS 2 9", "POLYGONS 3 7")
    for text in (POLYDATA, new, POLYDATA.lower().replace("# vtk datafile version", "# vtk DataFile Version")):
        assert is_grid(text.encode())
        assert elements(read_grid(text.encode())) == MIXED


def test_strips_of_triangles_of_vtk_polydata():
    text = POLYDATA.replace("POLYGONS 2 9\n4 0 1 2 3\n3 3 2 4", "TRIANGLE_STRIPS 1 6\n5 0 1 3 2 4")
    assert elements(read_grid(text.encode())) == {"triangle": [[0, 1, 3], [3, 1, 2], [3, 2, 4]]}


def test_binary_vtk_polydata():
    head = b"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\nPOINTS 4 double\n"
    data = head + SQUARE.astype(">f8").tobytes() + b"\nPOLYGONS 1 5\n" + np.array([4, 0, 1, 2, 3], ">i4").tobytes() + b"\n"
    contents = read_grid(data)
    assert elements(contents) == {"quad": [[0, 1, 2, 3]]}
    assert np.array_equal(contents.points, SQUARE)
    with pytest.raises(Damaged, match="it is truncated within 5 values"):
        read_grid(data[:-9])


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("POINTS 5", "POINTS 500000000", "does not have the 1500000000 values"),
        ("POINTS 5 float", "POINTS 5 quad", "an unknown VTK data type"),
        ("POLYGONS 2 9", "POLYGONS 3 9", "a list of corners is truncated"),
        ("3 3 2 4", "3 3 x 4", "contain a word that is not a whole number"),
        ("POINTS 5 float\n", "", "it has no points"),
    ],
)
def test_what_is_wrong_with_vtk_polydata_is_named(old, new, reason):
    with pytest.raises(Damaged, match=reason):
        read_grid(POLYDATA.replace(old, new, 1).encode())


@pytest.mark.parametrize("form", ["ascii", "binary", "appended", "zipped", "lz4", "lzma"])
def test_vtk_polydata_in_xml(form):
    data = vtp([*SQUARE, (0.5, 2, 0)], [[0, 1, 2, 3], [3, 2, 4]], form)
    contents = read_vtp(data)
    assert elements(contents) == MIXED
    assert np.array_equal(contents.points[:4], SQUARE)


@pytest.mark.parametrize(
    ("form", "old", "new", "reason"),
    [
        ("ascii", b"<Points>", b"<Point>", "line 4 is not valid XML"),
        ("ascii", b'type="PolyData"', b'type="ImageData"', "not a VTKFile of type PolyData"),
        ("ascii", b"0 1 2 3", b"0 1 2 x", "contain a word that is not a whole number"),
        ("ascii", b"<?xml", b"<!DOCTYPE a><?xml", "it declares XML entities"),
        ("ascii", b"4 7", b"4 9", "the offsets of its lists are not ascending"),
        ("binary", b'"Float64"', b'"Float63"', "an unknown VTK data type"),
        ("appended", b'offset="0"', b'offset="99999"', "a table starts after the end of the file"),
        ("zipped", b"vtkZLibDataCompressor", b"vtkFooDataCompressor", "its compression is not supported"),
        ("zipped", b"x\x9c", b"x\x00", "a packed table is damaged"),
    ],
)
def test_what_is_wrong_with_vtk_polydata_in_xml_is_named(form, old, new, reason):
    data = vtp([*SQUARE, (0.5, 2, 0)], [[0, 1, 2, 3], [3, 2, 4]], form)
    assert old in data
    with pytest.raises(Damaged, match=reason):
        read_vtp(data.replace(old, new, 1))


@pytest.mark.parametrize(
    ("packed", "data"),
    [
        (b"\x30abc", b"abc"),
        (b"\x24ab\x02\x00\x10c", b"ab" + 4 * b"ab" + b"c"),
        (b"\x1fa\x01\x00\xff\x01\x10b", b"a" + 275 * b"a" + b"b"),
        (b"\xf0\x02" + 17 * b"x", 17 * b"x"),
        (b"\x42abcd\x04\x00\x00", b"abcdabcdab"),
    ],
    ids=["literals", "match", "long match", "many literals", "no end"],
)
def test_blocks_of_lz4(packed, data):
    """LZ4 block format description: a token with both lengths, literals, an offset; a length of 15 goes on in further bytes."""
    assert lz4_block(packed, 1000) == data
    assert lz4_block(packed, 2) == data[:2]


@pytest.mark.parametrize("packed", [b"\x10a\x02\x00", b"\x10a\x00\x00", b"\x00\x01\x00"])
def test_a_match_before_the_beginning_of_an_lz4_block_is_damage(packed):
    with pytest.raises(Damaged, match="a packed table is damaged"):
        lz4_block(packed, 1000)


OFF_VERTICES = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 2 0\n"
OFF_FACES = "4 0 1 2 3\n3 3 2 4\n"
COLOURED = "".join(f"{line} 0 0 1 255 0 0 255\n" for line in OFF_VERTICES.splitlines())


@pytest.mark.parametrize(
    "text",
    [
        "OFF\n5 2 0\n" + OFF_VERTICES + OFF_FACES,
        "OFF 5 2 0\n" + OFF_VERTICES + OFF_FACES,
        "OFF5 2 0\n" + OFF_VERTICES + OFF_FACES,
        "off\n5 2 0\n" + OFF_VERTICES + OFF_FACES,
        "5 2 0\n" + OFF_VERTICES + OFF_FACES,
        "OFF\n5 2\n" + OFF_VERTICES + OFF_FACES,
        "OFF\n5\n2\n0\n" + OFF_VERTICES + OFF_FACES,
        "# exported\n\nOFF # text\n# counts\n5 2 6\n\n" + OFF_VERTICES + "# faces\n" + OFF_FACES + "\n\n",
        "OFF\r\n5 2 0\r\n" + (OFF_VERTICES + OFF_FACES).replace("\n", "\r\n"),
        "COFF\n5 2 0\n" + OFF_VERTICES.replace("\n", " 255 0 0 255\n") + OFF_FACES,
        "NOFF\n5 2 0\n" + OFF_VERTICES.replace("\n", " 0 0 1\n") + OFF_FACES,
        "STCNOFF 5 2 0\n" + COLOURED + OFF_FACES,
        "OFF\n5 2 0\n" + OFF_VERTICES + OFF_FACES.replace("\n", " 3 0.1 0.2 0.3\n"),
        "4OFF\n5 2 0\n0 0 0 1\n1 0 0 1\n1 1 0 1\n0 1 0 1\n1 4 0 2\n" + OFF_FACES,
    ],
    ids=[
        *(
            "plain",
            "counts behind",
            "no space",
            "lower case",
            "no word",
            "no edges",
            "counts apart",
            "comments",
            "Windows",
            "C",
            "N",
            "STCN",
        ),
        *("colours of faces", "4"),
    ],
)
def test_off_in_all_its_forms(text):
    contents = read_off(text.encode())
    assert elements(contents) == MIXED
    assert np.array_equal(contents.points, [*SQUARE.tolist(), (0.5, 2, 0)])


def test_off_with_edges_and_points_beside_its_faces():
    contents = read_off(("OFF 5 4 0\n" + OFF_VERTICES + "2 0 1\n1 4\n" + OFF_FACES).encode())
    assert elements(contents) == MIXED | {"line": [[0, 1]], "vertex": [[4]]}


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("OFF\n", "ends before its counts"),
        ("OFF x y z\n", "line 1 has a word instead of a whole number"),
        ("OFF -5 2 0\n", "line 1 must have the counts"),
        ("OFF 5 2 0\n" + OFF_VERTICES + "4 0 1 2 3\n", "has 6 lines after its counts, but 5 vertices and 2 faces"),
        ("OFF 5 1 0\n" + OFF_VERTICES + OFF_FACES, "line 8 is after the last of the 5 vertices and 1 faces"),
        ("OFF 5 2 0\n" + OFF_VERTICES.replace("1 1 0", "1 1") + OFF_FACES, "line 4 has 2 numbers instead of 3"),
        ("OFF 5 2 0\n" + OFF_VERTICES + OFF_FACES.replace("3 3 2 4", "4 3 2 4"), "face in line 8 has 3 corners instead of 4"),
        ("OFF BINARY\n5 2 0\n", "it is a binary OFF file"),
        ("nOFF\n3\n5 2 0\n", "number of dimensions is not 3"),
        ("4OFF\n1 0 0\n1 0 0 0\n", "vertex 0 .counted from 0. has a fourth coordinate of 0"),
        ("a poem of two\nlines\n", "line 1 has a word instead of a whole number"),
    ],
)
def test_what_is_wrong_with_an_off_file_is_named(text, reason):
    with pytest.raises(Damaged, match=reason):
        read_off(text.encode())
