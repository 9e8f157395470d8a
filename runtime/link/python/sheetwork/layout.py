"""Layout of a frame in shared memory. Every number in a sample is checked before access."""

import numpy as np

MAGIC = b"sheetlnk"
LAYOUT = 1
MOST_SHEETS = 4096

FRAME = np.dtype(
    [
        ("magic", "S8"),
        ("layout", "<u4"),
        ("header_bytes", "<u4"),
        ("sheet_bytes", "<u4"),
        ("sheets", "<u4"),
        ("bytes", "<u8"),
        ("epoch", "<u8"),
        ("frame", "<u8"),
        ("steps", "<u8"),
        ("time", "<f8"),
        ("dt", "<f8"),
        ("step_time", "<f8"),
        ("written_at", "<u8"),
        ("playing", "<u4"),
        ("complete", "<u4"),
        ("bodies", "<u4"),
        ("topology", "<u4"),
        ("bodies_at", "<u8"),
        ("units", "S32"),
    ]
)

SHEET = np.dtype(
    [
        ("name", "S64"),
        ("structure", "S32"),
        ("grid", "<u4", 3),
        ("masses", "<u4"),
        ("status", "<u4"),
        ("contacts", "<u4"),
        ("energy", "<f8", 4),
        ("positions", "<u8"),
        ("normals", "<u8"),
        ("strain", "<u8"),
        ("temperature", "<u8"),
        ("contact", "<u8"),
        ("contact_force", "<u8"),
        ("pin_force", "<u8"),
    ]
)

TOPOLOGY_MAGIC = b"sheettop"

TOPOLOGY = np.dtype(
    [
        ("magic", "S8"),
        ("layout", "<u4"),
        ("header_bytes", "<u4"),
        ("sheet_bytes", "<u4"),
        ("sheets", "<u4"),
        ("bytes", "<u8"),
        ("epoch", "<u8"),
        ("version", "<u4"),
        ("reserved", "<u4"),
    ]
)

SHEET_TOPOLOGY = np.dtype(
    [
        ("name", "S64"),
        ("masses", "<u4"),
        ("triangles", "<u4"),
        ("triangles_at", "<u8"),
        ("cells", "<u4", 2),
        ("cells_at", "<u8"),
    ]
)

STATUS = ("awake", "asleep", "unstable", "frozen")


def _array(data, offset, count, kind, width):
    """`count` rows of `width` numbers at byte `offset`; None for offset 0 or one outside the
    sample.
    """
    kind = np.dtype(kind)
    size = count * width * kind.itemsize
    if offset == 0 or offset % kind.itemsize or offset + size > data.size:
        return None
    view = data[offset : offset + size].view(kind)
    return view.reshape(count, width) if width > 1 else view


class Sheet:
    """A sheet of a frame: views into shared memory, copies once the next frame is requested."""

    def __init__(self, data, header):
        n = int(header["masses"])
        self.name = bytes(header["name"]).decode("utf-8", "replace")
        self.structure = bytes(header["structure"]).decode("utf-8", "replace")
        #: Nodes along the length, layers, nodes along the width.
        self.grid = tuple(int(i) for i in header["grid"])
        status = int(header["status"])
        self.status = STATUS[status] if status < len(STATUS) else "?"
        #: Number of nodes in contact with a body in the last step.
        self.contacts = int(header["contacts"])
        #: Kinetic, elastic, potential ("gravity") and total energy, J; None in an incomplete
        #: frame.
        energy = [float(e) for e in header["energy"]]
        self.energy = None if energy[3] != energy[3] else dict(zip(("kinetic", "elastic", "gravity", "total"), energy))
        #: n x 3, m.
        self.positions = _array(data, int(header["positions"]), n, "<f4", 3)
        #: n x 3, unit vectors; None in an incomplete frame.
        self.normals = _array(data, int(header["normals"]), n, "<f4", 3)
        #: n; None in an incomplete frame.
        self.strain = _array(data, int(header["strain"]), n, "<f4", 1)
        #: n, degrees Celsius; None without heat.
        self.temperature = _array(data, int(header["temperature"]), n, "<f4", 1)
        #: n, 1 for a node in contact with a body in the last step.
        self.contact = _array(data, int(header["contact"]), n, "u1", 1)
        #: n x 3, N, mean contact force and mean force of the pins in the last step; None unless the
        #: game records forces.
        self.contact_force = _array(data, int(header["contact_force"]), n, "<f4", 3)
        self.pin_force = _array(data, int(header["pin_force"]), n, "<f4", 3)
        #: m x 3, node indices of the triangles of closed cells; None in a frame requested
        #: without.
        self.triangles = None
        #: Length x width, True for an open cell; None in a frame requested without, or of a sheet
        #: without fracture and slits.
        self.open = None
        if self.positions is None:
            raise ValueError("the positions of a sheet lie outside the sample")


def _opened(data, whole, part, magic, what):
    """Checked header of a sample, and those of its sheets."""
    if data.size < whole.itemsize:
        raise ValueError(f"{data.size} bytes are no {what}")
    header = data[: whole.itemsize].view(whole)[0]
    if bytes(header["magic"]) != magic:
        raise ValueError(f"the sample is no {what} of Sheetwork")
    if header["layout"] != LAYOUT:
        raise ValueError(f"the game writes layout {header['layout']}, and this reader knows {LAYOUT}")
    own, each, count = int(header["header_bytes"]), int(header["sheet_bytes"]), int(header["sheets"])
    fits = own >= whole.itemsize and each >= part.itemsize and count <= MOST_SHEETS
    if not fits or own + count * each > data.size or int(header["bytes"]) != data.size:
        raise ValueError(f"the {what} says it has {header['bytes']} bytes and has {data.size}")
    return header, [data[at : at + part.itemsize].view(part)[0] for at in range(own, own + count * each, each)]


class Frame:
    """A frame of the whole world: views into shared memory, copies once the next frame is
    requested.
    """

    def __init__(self, data):
        header, heads = _opened(data, FRAME, SHEET, MAGIC, "frame")
        self.epoch = int(header["epoch"])
        self.frame = int(header["frame"])
        self.steps = int(header["steps"])
        self.time = float(header["time"])
        self.dt = float(header["dt"])
        #: Wall-clock time of the game's last step, s.
        self.step_time = float(header["step_time"])
        #: CLOCK_MONOTONIC at the time of writing, ns: `time.monotonic_ns()` is the same clock.
        self.written_at = int(header["written_at"])
        self.playing = bool(header["playing"])
        #: Whether the frame has normals, strain and energies.
        self.complete = bool(header["complete"])
        #: Number of the topology in this epoch.
        self.topology = int(header["topology"])
        #: Position (m) and rotation (quaternion x, y, z, w) of each body.
        bodies = _array(data, int(header["bodies_at"]), int(header["bodies"]), "<f4", 7)
        self.bodies = np.empty((0, 7), "<f4") if bodies is None else bodies
        self.sheets = [Sheet(data, head) for head in heads]

    def sheet(self, name):
        """The sheet of that name; None for an unknown name."""
        return next((s for s in self.sheets if s.name == name), None)


class Topology:
    """Triangles of the sheets, as copies."""

    def __init__(self, data):
        header, heads = _opened(data, TOPOLOGY, SHEET_TOPOLOGY, TOPOLOGY_MAGIC, "topology")
        self.epoch = int(header["epoch"])
        self.version = int(header["version"])
        #: Triangles and open cells of each sheet, in the order of a frame; None in place of cells
        #: of a sheet without fracture and slits.
        self.sheets = [_mesh(data, head) for head in heads]


def _mesh(data, header):
    """Triangles and open cells of a sheet."""
    count, masses = int(header["triangles"]), int(header["masses"])
    triangles = np.empty((0, 3), "<u4") if count == 0 else _array(data, int(header["triangles_at"]), count, "<u4", 3)
    if triangles is None:
        raise ValueError("the triangles of a sheet lie outside the sample")
    if count and int(triangles.max()) >= masses:
        raise ValueError(f"a triangle is of a mass beyond its {masses}")
    if int(header["cells_at"]) == 0:
        return triangles.copy(), None
    along, across = (int(n) for n in header["cells"])
    cells = _array(data, int(header["cells_at"]), along * across, "u1", 1)
    if cells is None:
        raise ValueError("the cells of a sheet lie outside the sample")
    return triangles.copy(), (cells != 0).reshape(across, along).T
