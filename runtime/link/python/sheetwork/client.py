"""Connection to a game: commands, frames and events."""

import ctypes
import json
import os
import stat
import time
import weakref

import iceoryx2 as iox2
import numpy as np

from .layout import LAYOUT, Frame, Topology

_BYTES = iox2.Slice[ctypes.c_uint8]
_WORDS = iox2.Slice[ctypes.c_uint64]
_LOOK_EVERY = 50e-6
_MOST_BYTES = 16 << 10


class LinkError(Exception):
    """An error of a link."""


class NoGame(LinkError):
    """No game serves a link of this name."""


class Refused(LinkError):
    """The game rejected a command, with the reason."""


class Silent(LinkError):
    """No answer from the game in time."""


class Full(LinkError):
    """The maximum number of processes is attached."""


class Unlike(LinkError):
    """The other end has another version or is not Sheetwork."""


def attach(name="", root=None, wait=0.0):
    """Attaches to the game that serves the link `name` (SHEETWORK_LINK, or "sheetwork", if empty).

    `root` is the folder of its files (SHEETWORK_LINK_ROOT, or the user's own), `wait` the time
    limit of the wait for a game, s. Raises NoGame, Full, Refused or Unlike.
    """
    end = time.monotonic() + wait
    while True:
        try:
            return Game(name, root)
        except NoGame:
            if time.monotonic() >= end:
                raise
            time.sleep(0.02)


def _folder(root):
    root = root or os.environ.get("SHEETWORK_LINK_ROOT") or f"/tmp/sheetwork-link-{os.geteuid()}"
    try:
        about = os.lstat(root)
    except OSError:
        return root, False
    if not stat.S_ISDIR(about.st_mode) or about.st_uid != os.geteuid() or about.st_mode & 0o077:
        raise Refused(f"{root}: must be a folder of this user with mode 0700")
    return root, True


def _prefix(root):
    value = 0x811C9DC5
    for byte in os.fsencode(root):
        value = ((value ^ byte) * 0x01000193) & 0xFFFFFFFF
    return f"sheetwork_{value:08x}_"


def _tidy(root):
    """Removes objects of processes that were killed before they set a size. iceoryx2 would wait for
    these without a time limit.
    """
    prefix = _prefix(root)
    for _ in range(40):
        unfinished = False
        for entry in os.scandir("/dev/shm"):
            try:
                about = entry.stat() if entry.name.startswith(prefix) else None
                if about is not None and about.st_size == 0:
                    if time.time() - about.st_mtime > 1.0:
                        os.unlink(entry.path)
                    else:
                        unfinished = True
            except OSError:
                continue
        if not unfinished:
            return True
        time.sleep(0.05)
    return False


def _text(value):
    """A value as in a scene file."""
    if isinstance(value, str):
        return value
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (list, tuple, np.ndarray)):
        return "(" + ", ".join(_text(v) for v in value) + ")"
    return repr(float(value))


def _bytes_of(sample, size=1):
    """Bytes of a sample or answer of elements of `size` bytes."""
    return ctypes.string_at(sample.payload_ptr, sample.header.number_of_elements * size)


class Game:
    """A connection to a running game. Use it in a `with` statement, or close it."""

    def __init__(self, name="", root=None):
        iox2.set_log_level(iox2.LogLevel.Fatal)
        self.name = name or os.environ.get("SHEETWORK_LINK") or "sheetwork"
        #: Time limit of the wait for an answer, s.
        self.patience = 2.0
        self.missed = 0
        self.restarts = 0
        #: Names of the sheets that are unstable by the last answer, frozen until a reset or a
        #: restore.
        self.stopped = []
        self._last = None
        root, exists = _folder(root)
        if not exists:
            raise NoGame(f'no game serves the link "{self.name}"')
        config = iox2.config.default()
        config.global_cfg.root_path = iox2.Path.new(root)
        config.global_cfg.prefix = iox2.FileName.new(_prefix(root))
        self._root = root
        # The creation of a node cleans up first.
        _tidy(root)
        builder = iox2.NodeBuilder.new().config(config).signal_handling_mode(iox2.SignalHandlingMode.Disabled)
        self._node = builder.create(iox2.ServiceType.Ipc)
        try:
            service = self._builder("control").request_response(_BYTES, _BYTES).open()
        except iox2.RequestResponseOpenError as error:
            raise self._not_opened(error) from None
        if service.dynamic_config.number_of_servers == 0:
            raise NoGame(f'no game serves the link "{self.name}"')
        self._control = service
        try:
            self._client = (
                service.client_builder()
                .initial_max_slice_len(_MOST_BYTES)
                .allocation_strategy(iox2.AllocationStrategy.Static)
                .create()
            )
        except iox2.ClientCreateError as error:
            raise _full(error, "command a game") from None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        """Detaches from the game."""
        client, self._client = self._client, None
        if client is not None:
            client.delete()
        self._control = self._node = None

    def _clean_up(self):
        """Removes the remains of terminated processes."""
        if _tidy(self._root):
            self._node.try_cleanup_dead_nodes()

    def _builder(self, what):
        return self._node.service_builder(iox2.ServiceName.new(f"sheetwork/{self.name}/{what}"))

    def _not_opened(self, error):
        if "DoesNotExist" in str(error):
            return NoGame(f'no game serves the link "{self.name}"')
        if "InsufficientPermissions" in str(error):
            return Refused("not allowed; a link is for its own user")
        if "ExceedsMaxNumberOfNodes" in str(error):
            return _full(error, "be attached to a game")
        return Unlike(f"the other end does not fit: {error}")

    def send(self, op, **arguments):
        """Sends a command and returns its answer, a dictionary. Raises Refused with the reason, or
        Silent.
        """
        data = json.dumps({"layout": LAYOUT, "op": op, **arguments}).encode()
        if len(data) > _MOST_BYTES:
            raise Refused(f"the command has {len(data)} bytes; at most {_MOST_BYTES} go")
        request = self._client.loan_slice_uninit(len(data))
        ctypes.memmove(request.payload_ptr, data, len(data))
        pending = request.assume_init().send()
        end = time.monotonic() + self.patience
        while True:
            response = pending.receive()
            if response is not None:
                answer = json.loads(_bytes_of(response))
                response.delete()
                pending.delete()
                self.stopped = answer.get("stopped", [])
                if not answer.get("ok"):
                    raise Refused(answer.get("error", "refused without a reason"))
                return answer
            if time.monotonic() > end:
                pending.delete()
                self._clean_up()
                raise Silent("the game does not answer")
            time.sleep(_LOOK_EVERY)

    def status(self):
        """Status of the game: scene, engine, dt, playing, sheets, process, events, stopped."""
        return self.send("status")

    def parameters(self):
        """All parameters of the running world: a list of dictionaries with path, value, unit, kind,
        min, max.
        """
        found, start = [], 0
        while start is not None:
            part = self.send("params", **{"from": start})
            found += part["params"]
            following = part.get("next")
            start = following if following is not None and following > start else None
        return found

    def get(self, path):
        """Value of a parameter: a number, a tuple, True or False, or text."""
        found = self.send("get", path=path)
        if found["kind"] == "boolean":
            return found["value"] == "true"
        if found["kind"] == "vector":
            return tuple(float(part) for part in found["value"].strip("()").split(","))
        try:
            return float(found["value"])
        except ValueError:
            return found["value"]

    def set(self, path, value):
        """Sets a parameter, in effect from the next step, and returns the old value as text.

        The value is a number, three numbers, True or False, or text. Raises Refused.
        """
        return self.send("set", path=path, value=_text(value))["old"]

    def play(self):
        """Continues the simulation."""
        self.send("play")

    def pause(self):
        """Pauses the simulation."""
        self.send("pause")

    def step(self, steps=1):
        """Takes steps, then pauses; returns the simulated time, s."""
        return self.send("step", steps=steps)["time"]

    def reset(self):
        """Resets the world to its scene."""
        self.send("reset")

    def load(self, file):
        """Opens a scene file on the game's machine."""
        self.send("load", file=os.path.abspath(file))

    def snapshot(self, name=""):
        """Stores a snapshot in the game's memory."""
        self.send("snapshot", name=name)

    def restore(self, name=""):
        """Restores a stored snapshot."""
        self.send("restore", name=name)

    def scene(self):
        """The scene of the game, as text."""
        text, start = "", 0
        while start is not None:
            part = self.send("scene", **{"from": start})
            text += part["text"]
            following = part.get("next")
            start = following if following is not None and following > start else None
        return text

    def grab(self, sheet, u, v, stiffness=100.0):
        """Grabs the material point (u, v), each 0 to 1, with a spring of `stiffness` N/m."""
        answer = self.send("grab", sheet=sheet, u=float(u), v=float(v), stiffness=float(stiffness))
        return Grab(self, answer["grab"], answer["position"])

    def _subscribe(self, what):
        try:
            service = self._builder(what).publish_subscribe(_WORDS).open()
        except iox2.PublishSubscribeOpenError as error:
            raise self._not_opened(error) from None
        try:
            return service, service.subscriber_builder().create()
        except iox2.SubscriberCreateError as error:
            raise _full(error, f"read a game's {what}") from None

    def frames(self, complete=False, seconds=None, count=None, newest=True, triangles=False):
        """Yields frames until `seconds` have passed or `count` frames have come.

        With `newest` older frames are skipped. With `triangles` sheets have `triangles` and `open`;
        a fractured sheet has fewer triangles. The arrays of a frame are views into shared memory
        until the next frame is requested, and copies from then on. An array kept by itself
        continues to occupy one of the reader's few samples: copy it. Raises Unlike for an
        unreadable frame.
        """
        service, port = self._subscribe("fields" if complete else "frames")
        meshes = _Meshes(self) if triangles else None
        end = None if seconds is None else time.monotonic() + seconds
        quiet, given = time.monotonic(), 0
        try:
            while (end is None or time.monotonic() < end) and (count is None or given < count):
                sample = _received(port)
                if sample is None:
                    if time.monotonic() - quiet > 1.0:
                        quiet = time.monotonic()
                        self._clean_up()
                    time.sleep(_LOOK_EVERY)
                    continue
                while newest:
                    following = _received(port)
                    if following is None:
                        break
                    sample.delete()
                    sample = following
                quiet = time.monotonic()
                frame = self._frame(sample)
                sample = None
                if meshes is not None and not meshes.give(frame):
                    continue
                given += 1
                try:
                    yield frame
                finally:
                    # Later use of the frame is on copies.
                    _kept(frame)
        finally:
            port.delete()
            del service
            if meshes is not None:
                meshes.close()

    def _frame(self, sample):
        kind = ctypes.c_uint8 * (8 * sample.header.number_of_elements)
        memory = kind.from_address(sample.payload_ptr)
        # The sample is released when the last array on it is collected; an earlier release would
        # crash Python.
        weakref.finalize(memory, sample.delete)
        data = np.frombuffer(memory, dtype=np.uint8)
        data.flags.writeable = False
        try:
            frame = Frame(data)
        except ValueError as problem:
            raise Unlike(str(problem)) from None
        if self._last is not None:
            epoch, number = self._last
            if epoch != frame.epoch:
                self.restarts += 1
            else:
                self.missed += max(0, frame.frame - number - 1)
        self._last = (frame.epoch, frame.frame)
        return frame

    def frame(self, complete=False, patience=2.0, triangles=False):
        """One frame, with arrays of its own. Raises Silent."""
        for frame in self.frames(complete, seconds=patience, count=1, triangles=triangles):
            return _kept(frame)
        raise Silent("no frame came")

    def events(self, seconds=None):
        """Yields events from now on: dictionaries with time_s, kind, sheet, body, place_m,
        energy_j.
        """
        service, port = self._subscribe("events")
        end = None if seconds is None else time.monotonic() + seconds
        try:
            while end is None or time.monotonic() < end:
                sample = port.receive()
                if sample is None:
                    time.sleep(1e-3)
                    continue
                event = json.loads(_bytes_of(sample, 8))
                sample.delete()
                yield event
        finally:
            port.delete()
            del service


class _Meshes:
    """Topology of a game's sheets."""

    def __init__(self, game):
        self._service, self._port = game._subscribe("topology")
        self._now = None

    def give(self, frame):
        """Sets the triangles of the sheets of `frame`; False if they have not arrived."""
        while True:
            sample = self._port.receive()
            if sample is None:
                break
            data = np.frombuffer(_bytes_of(sample, 8), dtype=np.uint8)
            sample.delete()
            try:
                self._now = Topology(data)
            except ValueError as problem:
                raise Unlike(str(problem)) from None
        now = self._now
        if now is None or now.epoch != frame.epoch or now.version < frame.topology:
            return False
        for sheet, (triangles, cells) in zip(frame.sheets, now.sheets):
            sheet.triangles, sheet.open = triangles, cells
        return True

    def close(self):
        self._port.delete()
        self._service = None


def _full(error, what):
    """Exception for an error in the creation of a port."""
    if "ExceedsMax" in str(error):
        text = f"no more than 12 processes may {what} at once, and as many do: end one of them, and try again half a second later"
        return Full(text)
    return LinkError(f"shared memory: {error}")


def _received(port):
    """The next sample, or None."""
    try:
        return port.receive()
    except iox2.ReceiveError as error:
        if "Borrow" in str(error):
            raise Refused("arrays of earlier frames are held; copy what is kept") from None
        raise


def _kept(frame):
    """Copies the frame's arrays, so that it outlives its sample in shared memory."""
    for sheet in frame.sheets:
        for name in ("positions", "normals", "strain", "temperature", "contact", "contact_force", "pin_force"):
            array = getattr(sheet, name)
            if array is not None:
                setattr(sheet, name, array.copy())
    frame.bodies = frame.bodies.copy()
    return frame


class Grab:
    """A grab of a sheet."""

    def __init__(self, game, number, position):
        self._game, self._number = game, number
        #: Position of the point when it was grabbed, m.
        self.position = tuple(position)

    def pull(self, target):
        """Moves the hand to `target` (m); returns the force on it (N) and the position of the point
        (m).
        """
        answer = self._game.send("pull", grab=self._number, target=[float(c) for c in target])
        return tuple(answer["force"]), tuple(answer["position"])

    def release(self):
        """Releases the grab."""
        self._game.send("release", grab=self._number)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.release()
        except LinkError:
            pass
