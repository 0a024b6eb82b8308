"""Files of VTK's polygons in XML, written by hand."""

import base64
import zlib

import numpy as np

TYPES = {"f": "Float64", "i": "Int64"}


def vtp(points, faces, form):
    """The bytes of a file; form: "ascii", "binary" (in base 64), "appended" (raw), "zipped" (raw, packed by zlib)."""
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
        packed = zlib.compress(data)
        zipped = np.array([1, len(data), 0, len(packed)], "<u8").tobytes() + packed
        content = {"ascii": " ".join(map(str, values.ravel().tolist())), "binary": base64.b64encode(plain).decode()}.get(
            form, ""
        )
        place = f'format="appended" offset="{len(appended)}"' if not content else f'format="{form}"'
        named = f'Name="{name}" ' if name else 'NumberOfComponents="3" '
        xml[name] = f'<DataArray type="{TYPES[values.dtype.kind]}" {named}{place}>{content}</DataArray>'
        appended += zipped if form == "zipped" else plain
    packer = 'compressor="vtkZLibDataCompressor" ' if form == "zipped" else ""
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
