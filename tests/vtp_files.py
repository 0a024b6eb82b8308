"""VTK XML files of polygons (.vtp), written without a library, in all encodings."""

import base64
import lzma
import zlib

import numpy as np


def lz4(data):
    """Return data in LZ4 format without compression: one block of literals."""
    n = len(data) - 15
    return bytes([0xF0 if n >= 0 else len(data) << 4]) + (b"\xff" * (n // 255) + bytes([n % 255]) if n >= 0 else b"") + data


PACKERS = {
    "zipped": ("vtkZLibDataCompressor", zlib.compress),
    "lzma": ("vtkLZMADataCompressor", lzma.compress),
    "lz4": ("vtkLZ4DataCompressor", lz4),
}
TYPES = {"f": "Float64", "i": "Int64"}


def vtp(points, faces, form):
    """Return the bytes of a file with points and faces; form: encoding "ascii", "binary" (base 64), "appended" (raw), or
    compressed: "zipped", "lz4", "lzma"."""
    corners = np.array([corner for face in faces for corner in face], "<i8")
    tables = {
        "": np.asarray(points, "<f8"),
        "connectivity": corners,
        "offsets": np.cumsum([len(face) for face in faces], dtype="<i8"),
    }
    appended, xml = b"", {}
    for name, values in tables.items():
        data = values.tobytes()
        plain = np.uint64(len(data)).tobytes() + data
        packed = PACKERS.get(form, PACKERS["zipped"])[1](data)
        zipped = np.array([1, len(data), 0, len(packed)], "<u8").tobytes() + packed
        content = {"ascii": " ".join(map(str, values.ravel().tolist())), "binary": base64.b64encode(plain).decode()}.get(
            form, ""
        )
        place = f'format="appended" offset="{len(appended)}"' if not content else f'format="{form}"'
        named = f'Name="{name}" ' if name else 'NumberOfComponents="3" '
        xml[name] = f'<DataArray type="{TYPES[values.dtype.kind]}" {named}{place}>{content}</DataArray>'
        appended += zipped if form in PACKERS else plain
    packer = f'compressor="{PACKERS[form][0]}" ' if form in PACKERS else ""
    head = f'''<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" {packer}byte_order="LittleEndian" header_type="UInt64">
<PolyData><Piece NumberOfPoints="{len(points)}" NumberOfPolys="{len(faces)}">
<Points>{xml[""]}</Points>
<Polys>{xml["connectivity"]}{xml["offsets"]}</Polys>
</Piece></PolyData>
'''
    if form in ("ascii", "binary"):
        return (head + "</VTKFile>").encode()
    return head.encode() + b'<AppendedData encoding="raw">\n_' + appended + b"\n</AppendedData></VTKFile>"
