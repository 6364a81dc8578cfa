#!/usr/bin/env python3
"""Streams a folding path to a controller, written from PROTOCOL.md alone."""
from __future__ import annotations

import argparse
import json
import math
import random
import re
import secrets
import select
import socket
import struct
import sys
import time
import zlib
from dataclasses import dataclass, field

VERSION = 3
SCHEMA = 0xDA8D9DB4  # the CRC-32 of the examples of messages and values
MASK = (1 << 64) - 1

# ---------------------------------------------------------------- values

# Kinds of values with a number in front: their variants in order, each with the kinds of its fields.
KINDS = """
interpolation = Linear | Hermite | HalfAngle | Homogeneous
command = Start | Hold | Resume | Unload | Clear | Stand | Forget | Jog u16 ?f32 ?f32
state = Idle | Ready | Running | Holding | Done | Faulted
reason = None | HoldCommand | Underrun | Silence | Lag u16 | StopLine | Session | Refused setpoint | Fault fault | \
    Approach | Lease | LateTick
fault = Stalled u16 | Leap u16 | Torn u16
denial = State | Moving | Groups | Empty | Place | Jump u16 | Held | Unknown u16 | Spread u16 | Range | Nonce
refused = Setpoint setpoint | Path denial | Room | Pieces | Incomplete | Limits u16 | Hinge u16 | Stars | Closure
setpoint = State | Full | Sequence u32 | Groups | NotFinite u16 | HalfTurn u16 | Weight u16 | Order | Range u16 | \
    Speed u16 | Acceleration u16 | Open u16 | OpenBetween u16
item = Sheet interpolation u16 u16 u16 f32 u32 u32 f32 f32 | Limits bytes | Hinges bytes | Spokes bytes | \
    Setpoint u32 f32 bool bytes | Nodes bytes
host = Hello u16 u32 u32 | Item u16 item | Command u8 command | Alive | Pair bytes | Seen u32 u16
controller = Mismatch u32 u16 u32 | Welcome u32 u32 u64 u8 u16 u16 u16 u16 | Unknown | \
    Report u16 u16 u8 u8 bool ?refused u8 ?denial state reason u32 f32 u32 bool bool | \
    Telemetry u64 state f32 u32 f32 u16 bytes | Measured u64 u16 ?f32 bytes
"""
ENUMS = {line.split(" = ")[0]: [tuple(each.split()) for each in line.split(" = ")[1].split("|")]
         for line in KINDS.strip().splitlines()}


class Bad(Exception):
    """Something that was read is not what the specification allows."""


class Reader:
    """Takes values from the front of some bytes."""

    def __init__(self, data: bytes, at: int = 0) -> None:
        """Begins at a byte of the data."""
        self.data, self.at = data, at

    def take(self, count: int) -> bytes:
        """Takes some bytes as they are."""
        if self.at + count > len(self.data):
            raise Bad(f"byte {self.at}: the end comes too soon")
        self.at += count
        return self.data[self.at - count:self.at]

    def varint(self, bits: int) -> int:
        """Takes a varint of at most so many bits."""
        value = shift = 0
        while True:
            byte = self.take(1)[0]
            value |= (byte & 127) << shift
            shift += 7
            if value >> bits or (byte & 128 and shift >= max(bits, 32)):
                raise Bad(f"byte {self.at - 1}: a number of more than {bits} bits")
            if byte < 128:
                return value

    def floats(self, count: int) -> list[float]:
        """Takes some 32-bit floating-point numbers."""
        return list(struct.unpack(f"<{count}f", self.take(4 * count)))

    def value(self, kind: str):
        """Takes a value of a named kind; one with a number in front becomes a tuple with its name first."""
        if kind[0] == "?":
            return self.value(kind[1:]) if self.value("bool") else None
        if kind in ENUMS:
            number = self.varint(32)
            if number >= len(ENUMS[kind]):
                raise Bad(f"no {kind} has the number {number}")
            name, *kinds = ENUMS[kind][number]
            return (name, *[self.value(each) for each in kinds])
        if kind in ("u8", "bool"):
            byte = self.take(1)[0]
            if kind == "bool" and byte > 1:
                raise Bad(f"byte {self.at - 1}: neither yes nor no")
            return bool(byte) if kind == "bool" else byte
        if kind == "bytes":
            return self.take(self.varint(32))
        return self.floats(1)[0] if kind == "f32" else self.varint(int(kind[1:]))


def varint(value: int) -> bytes:
    """Writes a varint."""
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out) + bytes([value])


def encode(kind: str, value) -> bytes:
    """Writes a value of a named kind."""
    if kind[0] == "?":
        return b"\0" if value is None else b"\1" + encode(kind[1:], value)
    if kind in ENUMS:
        number = [variant[0] for variant in ENUMS[kind]].index(value[0])
        fields = zip(ENUMS[kind][number][1:], value[1:], strict=True)
        return varint(number) + b"".join(encode(each, part) for each, part in fields)
    if kind in ("u8", "bool"):
        return bytes([value])
    if kind == "bytes":
        return varint(len(value)) + value
    return struct.pack("<f", value) if kind == "f32" else varint(value)


def decode(kind: str, data: bytes):
    """Reads a value that takes all of the bytes."""
    reader = Reader(data)
    value = reader.value(kind)
    if reader.at != len(data):
        raise Bad(f"{len(data) - reader.at} bytes too many")
    return value


# ---------------------------------------------------------------- paths

@dataclass
class Path:
    """A path, as a `.traj` file has it."""

    interpolation: int
    limits: list[list[float]]
    hinges: list[int]
    spokes: list[tuple[int, float, float]]
    closure: float
    knots: list[tuple[float, list[list[float]]]]
    most_lag: float = math.inf
    gaps: list[float] = field(default_factory=list)

    @property
    def numbers(self) -> int:
        """How many numbers a knot has for each group."""
        return 4 if self.interpolation == 3 else 2


def require(holds: bool, what: str) -> None:
    """Refuses something that does not hold."""
    if not holds:
        raise Bad(what)


def read_path(data: bytes) -> Path:
    """Reads a `.traj` file and refuses one that breaks a rule."""
    require(data[:4] == b"FPTJ", "byte 0: not a .traj file")
    require(data[4:5] in (b"\2", b"\3", b"\4"), "byte 4: another version")
    require(len(data) > 9 and zlib.crc32(data[:-4]) == int.from_bytes(data[-4:], "little"), "wrong checksum")
    reader = Reader(data[:-4], 5)
    interpolation = reader.varint(32)
    require(interpolation < 4, "byte 5: no such interpolation")
    groups = reader.varint(16)
    limits = [reader.floats(4) for _ in range(groups)]
    hinges = [reader.varint(32) for _ in range(reader.varint(32))]
    spokes = [(reader.varint(32), *reader.floats(2)) for _ in range(reader.varint(32))]
    closure = reader.floats(1)[0]
    path = Path(interpolation, limits, hinges, spokes, closure, [])
    for _ in range(reader.varint(32)):
        path.knots.append((reader.floats(1)[0], [reader.floats(path.numbers) for _ in range(groups)]))
    if data[4] < 4:
        times = [at for at, _ in path.knots]
        path.knots = [(at - before, groups) for before, (at, groups) in zip(times[:1] + times, path.knots)]
    if data[4] > 2:
        path.most_lag, path.gaps = reader.floats(1)[0], reader.floats(reader.varint(32))
    number = int.from_bytes(reader.take(4), "little") if data[4] > 3 else path_number(path)
    require(reader.at == len(data) - 4, f"byte {reader.at}: the file is too long")
    check_sheet(path)
    check_knots(path)
    require(number == path_number(path), "the number of the path is not that of its numbers")
    return path


def check_sheet(path: Path) -> None:
    """Refuses wrong limits, hinges and spokes."""
    groups = len(path.limits)
    for group, (low, high, speed, acceleration) in enumerate(path.limits):
        require(math.isfinite(low) and math.isfinite(high) and low <= high, f"group {group}: no range of angles")
        require(speed > 0 and acceleration > 0, f"group {group}: a largest rate that is not above 0")
    for hinge, code in enumerate(path.hinges):
        require(code >> 1 < groups, f"hinge {hinge}: has no group")
    for spoke, (code, x, y) in enumerate(path.spokes):
        require(code >> 2 < groups, f"spoke {spoke}: has no group")
        require(abs(math.hypot(x, y) - 1) <= 1.2e-4, f"spoke {spoke}: its direction is not of length 1")
    require(not path.spokes or bool(path.spokes[-1][0] & 2), f"spoke {len(path.spokes) - 1}: ends no vertex")
    require(math.isfinite(path.closure) and path.closure >= 0, "closure residual: not a residual")
    require(path.most_lag > 0, "most lag: a distance that is not above 0")
    require(len(path.gaps) in (0, len(path.hinges)), "gaps: neither one for each hinge nor none")
    require(all(math.isfinite(gap) and gap >= 0 for gap in path.gaps), "gaps: one that is no gap")


def check_knots(path: Path) -> None:
    """Refuses wrong spans, angles and weights."""
    half_turn = struct.unpack("<f", struct.pack("<f", math.pi))[0]
    for knot, (span, groups) in enumerate(path.knots):
        later = span > 0 if knot else span == 0
        require(math.isfinite(span) and later, f"knot {knot}: its span is not above 0, or 0 at the first knot")
        for group, values in enumerate(groups):
            where = f"knot {knot}, group {group}"
            require(all(map(math.isfinite, values)), f"{where}: a number that is not finite")
            require(path.limits[group][0] <= values[0] <= path.limits[group][1], f"{where}: beyond its limits")
            require(path.interpolation != 2 or abs(values[0]) < half_turn, f"{where}: half a turn")
            require(path.numbers == 2 or values[2] > 0, f"{where}: a weight that is not above 0")


def packed_hinges(path: Path) -> tuple[bytes, int]:
    """Packs the codes of all hinges, and tells how many bits one takes."""
    bits = max(1, (2 * len(path.limits) - 1).bit_length())
    whole = sum(code << bits * hinge for hinge, code in enumerate(path.hinges))
    return whole.to_bytes((bits * len(path.hinges) + 7) // 8, "little"), bits


def path_number(path: Path) -> int:
    """Computes the number that tells this path from others."""
    data = packed_hinges(path)[0]
    data += b"".join(struct.pack("<Iff", *spoke) for spoke in path.spokes)
    for span, groups in path.knots:
        values = [span, *[group[0] for group in groups], *[group[1] for group in groups]]
        values += [number for group in groups for number in group[2:]]
        data += struct.pack(f"<{len(values)}f", *values)
    return zlib.crc32(data, path.interpolation) or 1


def pieces(data: bytes, size: int) -> list[bytes]:
    """Cuts bytes into pieces of a size; the last one may be shorter."""
    return [data[at:at + size] for at in range(0, len(data), size)]


def path_items(path: Path, knot: int, behind: float) -> list[tuple]:
    """Lists all items of a path that begins some seconds behind a knot."""
    kind = ENUMS["interpolation"][path.interpolation]
    items: list[tuple] = [("Sheet", kind, len(path.limits), len(path.hinges), len(path.spokes), path.closure,
                           path_number(path), knot, behind, path.most_lag)]
    limits = b"".join(struct.pack("<4f", *group) for group in path.limits)
    items += [("Limits", piece) for piece in pieces(limits, 208)]
    codes, bits = packed_hinges(path)
    unit = bits // math.gcd(bits, 8)
    items += [("Hinges", piece) for piece in pieces(codes, 208 // unit * unit)]
    spokes = b"".join(struct.pack("<Hff", *spoke) for spoke in path.spokes)
    items += [("Spokes", piece) for piece in pieces(spokes, 200)]
    for number, (span, groups) in list(enumerate(path.knots))[knot:]:
        *first, last = pieces(b"".join(struct.pack(f"<{path.numbers}f", *group) for group in groups), 208)
        items += [("Nodes", piece) for piece in first]
        items.append(("Setpoint", number, span, number == len(path.knots) - 1, last))
    return items


def residuals(path: Path, angles: list[float]) -> list[float]:
    """Computes how far each essential vertex is from closed."""
    out, (w, x, y, z) = [], (1.0, 0.0, 0.0, 0.0)
    for code, ax, ay in path.spokes:
        half = angles[code >> 2] * (-0.5 if code & 1 else 0.5)
        c, sx, sy = math.cos(half), math.sin(half) * ax, math.sin(half) * ay
        w, x, y, z = w * c - x * sx - y * sy, w * sx + x * c - z * sy, w * sy + y * c + z * sx, z * c + x * sy - y * sx
        if code & 2:
            out.append(2 * math.sqrt(x * x + y * y + z * z))
            w, x, y, z = 1.0, 0.0, 0.0, 0.0
    return out


def cubic(s: float, span: float, a: float, da: float, b: float, db: float) -> float:
    """Follows a cubic from one value and rate to another."""
    t = 1 - s
    return a * t * t * (1 + 2 * s) + b * s * s * (3 - 2 * s) + span * s * t * (da * t - db * s)


def angles_on(path: Path, knot: int, behind: float) -> list[float]:
    """Computes all angles some seconds behind a knot. The formulas are guesses that a controller has confirmed."""
    knot, later = min(knot, len(path.knots) - 1), min(knot + 1, len(path.knots) - 1)
    span = path.knots[later][0] or 1.0
    s, out = min(max(behind / span, 0.0), 1.0), []
    for (a, da, *m), (b, db, *n) in zip(path.knots[knot][1], path.knots[later][1]):
        if path.interpolation == 0:
            out.append(a + (b - a) * s)
        elif path.interpolation == 1:
            out.append(cubic(s, span, a, da, b, db))
        else:
            wa, dwa, wb, dwb = (m + n) if m else (1 / math.cos(a / 2), 0.0, 1 / math.cos(b / 2), 0.0)
            if not m:
                dwa, dwb = wa * math.tan(a / 2) * da / 2, wb * math.tan(b / 2) * db / 2
            ca, sa, cb, sb = math.cos(a / 2), math.sin(a / 2), math.cos(b / 2), math.sin(b / 2)
            low = cubic(s, span, wa * ca, dwa * ca - wa * sa * da / 2, wb * cb, dwb * cb - wb * sb * db / 2)
            high = cubic(s, span, wa * sa, dwa * sa + wa * ca * da / 2, wb * sb, dwb * sb + wb * cb * db / 2)
            out.append(2 * math.atan2(high, low))
    return out


# ---------------------------------------------------------------- frames

def stuff(data: bytes) -> bytes:
    """Stuffs a frame (COBS) and ends it with a 0."""
    out, block, ended = bytearray(), bytearray(), True
    for byte in data:
        ended = True
        if byte:
            block.append(byte)
        if not byte or len(block) == 254:
            ended = byte == 0
            out += bytes([len(block) + 1]) + block
            block.clear()
    if ended:
        out += bytes([len(block) + 1]) + block
    return bytes(out) + b"\0"


def unstuff(data: bytes) -> bytes:
    """Undoes `stuff`, of what stands before the 0."""
    out, at = bytearray(), 0
    while at < len(data):
        code = data[at]
        require(code > 0 and at + code <= len(data), "a block of a frame is cut off")
        out += data[at + 1:at + code]
        at += code
        if code != 255 and at < len(data):
            out.append(0)
    return bytes(out)


def sip_hash(key: bytes, data: bytes) -> bytes:
    """Computes the tag SipHash-2-4, little endian."""
    def rounds(count: int) -> None:
        """Mixes the state."""
        nonlocal a, b, c, d
        for _ in range(count):
            a, c = (a + b) & MASK, (c + d) & MASK
            b, d = turn(b, 13) ^ a, turn(d, 16) ^ c
            a, c = (turn(a, 32) + d) & MASK, (c + b) & MASK
            b, d = turn(b, 17) ^ c, turn(d, 21) ^ a
            c = turn(c, 32)

    def turn(value: int, by: int) -> int:
        """Turns a word to the left."""
        return (value << by | value >> 64 - by) & MASK

    k0, k1 = struct.unpack("<QQ", key)
    a, b, c, d = k0 ^ 0x736F6D6570736575, k1 ^ 0x646F72616E646F6D, k0 ^ 0x6C7967656E657261, k1 ^ 0x7465646279746573
    padded = data + bytes(7 - len(data) % 8) + bytes([len(data) & 255])
    for (word,) in struct.iter_unpack("<Q", padded):
        d ^= word
        rounds(2)
        a ^= word
    c ^= 255
    rounds(4)
    return struct.pack("<Q", a ^ b ^ c ^ d)


def session_key(shared: bytes, direction: int, host: int, controller: int, session: int) -> bytes:
    """Makes the key of one direction of a session."""
    rest = struct.pack("<QQI", host, controller, session)
    return b"".join(sip_hash(shared, bytes([direction, half]) + rest) for half in (0, 1))


class Protection:
    """Makes the host's frames, and takes the controller's, with a key or without."""

    def __init__(self, key: bytes | None, nonce: int, node: int = 0) -> None:
        """Begins without a session."""
        self.key, self.nonce, self.node = key, nonce, node
        self.session = self.controller = self.epoch = self.sent = self.taken = 0
        self.keys: dict[tuple[int, int, int, int], bytes] = {}

    def offer(self, session: int, controller: int, epoch: int) -> None:
        """Goes over to an offered session."""
        if session != self.session or controller != self.controller:
            self.taken = 0
        self.session, self.controller, self.epoch = session, controller, epoch

    def tag(self, direction: int, session: int, data: bytes) -> bytes:
        """Computes the tag of a frame."""
        nonces = (self.nonce, self.controller) if session else (0, 0)
        which = (direction, *nonces, session)
        if which not in self.keys:
            self.keys[which] = session_key(self.key, *which)
        return sip_hash(self.keys[which], data)

    def seal(self, session: int, message: bytes) -> bytes:
        """Makes a frame of a message."""
        frame = struct.pack("<BI", self.node, session) + message
        if self.key is None:
            return frame + struct.pack("<I", zlib.crc32(frame))
        if session:
            self.sent += 1
            require(self.sent < 1 << 32, "all counters are used")
            frame += struct.pack("<BI", self.epoch, self.sent)
        else:
            frame += struct.pack("<I", self.nonce >> 32)
        return frame + self.tag(1, session, frame)

    def open(self, frame: bytes) -> tuple[int, bytes]:
        """Takes session and message from a frame of the controller."""
        end = 4 if self.key is None else 12
        require(6 + end <= len(frame) <= 256 and frame[0] == self.node, "no frame for this host")
        session = int.from_bytes(frame[1:5], "little")
        if self.key is None:
            require(zlib.crc32(frame[:-4]) == int.from_bytes(frame[-4:], "little"), "wrong checksum")
            return session, frame[5:-4]
        require(session in (0, self.session) and self.tag(2, session, frame[:-8]) == frame[-8:], "wrong tag")
        counter = int.from_bytes(frame[-12:-8], "little")
        if session:
            require(counter > self.taken, "an old frame")
            self.taken = counter
        else:
            require(counter == self.nonce >> 32, "an answer to another host")
        return session, frame[5:-12]


# ---------------------------------------------------------------- the host

def ahead(number: int, of: int, bits: int) -> int:
    """Tells how far a number that goes round is ahead of another, below 0 if it is behind."""
    half = 1 << bits - 1
    return (number - of + half) % (2 * half) - half


class Retry:
    """The retry time, as RFC 6298 has it, and the window."""

    def __init__(self) -> None:
        """Begins without a measurement."""
        self.mean, self.deviation, self.shortest, self.window, self.repeats = 0.0, 0.0, math.inf, 64, 0

    def measured(self, trip: float) -> None:
        """Takes a round trip of something that was sent once."""
        if self.shortest == math.inf:
            self.mean, self.deviation = trip, trip / 2
        else:
            self.deviation += (abs(self.mean - trip) - self.deviation) / 4
            self.mean += (trip - self.mean) / 8
        self.shortest = min(self.shortest, trip)
        self.window = min(self.window * 2, 1 << 16) if trip <= self.shortest + 0.2 else max(self.window // 2, 1)

    def seconds(self) -> float:
        """Tells the retry time."""
        base = 0.03 if self.shortest == math.inf else min(max(self.mean + 4 * self.deviation, 0.03), 0.5)
        return min(base * 2 ** min(self.repeats, 10), 0.5)


class Finished(Exception):
    """The end of the run: an outcome and a reason."""


@dataclass
class Sent:
    """When something was sent first and last, and how often."""

    first: float
    last: float
    times: int = 1


@dataclass
class Told:
    """What the controller has told, checked against the path."""

    telemetry: int = 0
    largest_closure: float = 0.0
    off_path: float = 0.0
    measured: int = 0
    largest_lag: float = 0.0
    time: int = -1
    state: str = "None"
    rate: float = 0.0
    place: tuple[int, float] = (0, 0.0)
    angles: list[float | None] = field(default_factory=list)
    before: list[float | None] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)


class Host:
    """Sends a path and follows it to the end."""

    def __init__(self, path: Path, link: socket.socket, key: bytes | None, options: argparse.Namespace) -> None:
        """Begins with a greeting to be sent."""
        self.path, self.link, self.options = path, link, options
        nonce = secrets.randbits(64) if key else secrets.randbelow((1 << 32) - 1) + 1
        self.protection, self.id, self.retry, self.told = Protection(key, nonce), nonce & 0xFFFFFFFF, Retry(), Told()
        self.random, self.buffer = random.Random(options.seed), b""
        self.session, self.begun, self.report = 0, False, None
        self.hello, self.began, self.heard, self.silent_since = -1.0, time.monotonic(), 0.0, None
        self.last_sent = self.last_counted = 0.0
        self.items, self.base, self.next, self.high, self.limit = [], 0, 0, 0, 0
        self.trips: dict[int, Sent] = {}
        self.progress, self.sent_again, self.seen = 0.0, 0, None
        self.number, self.command, self.command_sent = 0, None, None
        self.phase, self.motion, self.pause, self.rested, self.beginning = "load", None, 0.0, 0, (0, 0.0)

    # -- frames

    def send(self, message: tuple, session: int | None = None) -> int:
        """Sends one message, and tells the bytes on the line; some are dropped on purpose."""
        session = self.session if session is None else session
        frame = stuff(self.protection.seal(session, encode("host", message)))
        if self.random.random() >= self.options.drop:
            self.link.sendall(frame)
        now = time.monotonic()
        if session and message[0] != "Seen":
            self.last_sent = now
            self.silent_since = self.silent_since or now
        return len(frame)

    def receive(self, wait: float) -> None:
        """Takes all frames that have come."""
        if not select.select([self.link], [], [], wait)[0]:
            return
        data = self.link.recv(65536)
        if not data:
            raise Finished("lost", "the connection was closed")
        *stuffed, self.buffer = (self.buffer + data).split(b"\0")
        for each in stuffed:
            if each and self.random.random() >= self.options.drop:
                try:
                    session, message = self.protection.open(unstuff(each))
                    message = decode("controller", message)
                except Bad:
                    continue
                self.take(session, message)

    def take(self, session: int, message: tuple) -> None:
        """Acts on a message of the controller."""
        name, now = message[0], time.monotonic()
        if session == 0:
            if name == "Mismatch" and message[1] == self.id:
                raise Finished("mismatch", f"version {message[2]}, schema {message[3]:08x}")
            if name == "Welcome" and message[1] == self.id and not self.begun and message[2] != self.session:
                self.welcome(message, now)
        elif session == self.session:
            if name == "Unknown":
                if self.begun:
                    raise Finished("lost", "the session is not known any more")
                self.session, self.hello, self.silent_since = 0, -1.0, None
                return
            self.begun, self.heard, self.retry.repeats = True, now, 0
            if name == "Report":
                self.take_report(message, now)
            elif name == "Telemetry":
                self.take_telemetry(*message[1:])
            elif name == "Measured":
                self.take_measured(*message[1:])

    def welcome(self, message: tuple, now: float) -> None:
        """Takes an offered session and says the first word in it."""
        _, _, self.session, nonce, epoch, *room = message
        self.protection.offer(self.session, nonce, epoch)
        need = [len(self.path.limits), len(self.path.hinges), len(self.path.spokes)]
        if any(a > b for a, b in zip(need, room)):
            raise Finished("room", f"the path needs {need}, the controller has {room[:3]}")
        self.retry.repeats, self.heard = 0, now
        self.send(("Alive",))

    def take_report(self, report: tuple, now: float) -> None:
        """Takes acknowledgements, room and answers from a report."""
        (following, limit, count, epoch, gap, refusal, last) = report[1:8]
        done, room = self.base + ahead(following, self.base, 16), self.limit + ahead(limit, self.limit, 16)
        if done > self.high:
            return
        if self.report is None or count != self.report[3]:
            self.last_counted, self.silent_since = now, None
        self.report, self.protection.epoch, self.limit = report, epoch, max(room, self.limit)
        if not self.items and self.limit > 0:
            self.beginning = self.place_of(report)
            self.items = path_items(self.path, *self.beginning)
        if done > self.base:
            trip = self.trips[done - 1]
            if trip.times == 1:
                self.retry.measured(now - trip.first)
            for number in range(self.base, done):
                del self.trips[number]
            self.base, self.next, self.progress = done, max(self.next, done), now
        if gap and done == self.base:
            self.next = self.base
        if self.command and last == self.number:
            if self.command_sent.times == 1:
                self.retry.measured(now - self.command_sent.first)
            command, self.command = self.command[0], None
            self.answered(command, report[8], now)
        if refusal and done == self.base:
            raise Finished("refused", f"item {following}: {refusal}")

    def place_of(self, report: tuple) -> tuple[int, float]:
        """Tells where to begin: at the place that the controller tells, if it is on this path."""
        knot, behind, number, known = report[11:15]
        on_it = known and number == path_number(self.path) and knot < len(self.path.knots)
        return (knot, behind) if on_it else (0, 0.0)

    def take_telemetry(self, at: int, state: tuple, rate: float, knot: int, behind: float, first: int,
                       data: bytes) -> None:
        """Puts the pieces of a telemetry together, and says that they were seen."""
        told, angles = self.told, struct.unpack(f"<{len(data) // 4}f", data)
        if at < told.time:
            return
        if at > told.time:
            told.before = told.angles
            told.angles = [None] * len(self.path.limits)
        told.time, told.state, told.rate, told.place = at, state[0], rate, (knot, behind)
        told.angles[first:first + len(angles)] = angles
        self.seen = ("Seen", at & 0xFFFFFFFF, first + len(angles))
        if self.motion is None and state[0] == "Running":
            self.motion = time.monotonic()
        if angles and self.motion is not None and None not in told.angles:
            self.check_telemetry()
        if not self.holding():
            self.send(self.seen)

    def take_measured(self, at: int, first: int, alone: float | None, data: bytes) -> None:
        """Compares measured hinges with what was commanded in the same tick."""
        told = self.told
        if at != told.time or alone is not None or not told.angles or None in told.angles:
            return
        for code, (angle,) in zip(self.path.hinges[first:], struct.iter_unpack("<f", data)):
            if not math.isnan(angle):
                lag = abs(angle - told.angles[code >> 1] * (-1 if code & 1 else 1))
                told.measured, told.largest_lag = told.measured + 1, max(told.largest_lag, lag)

    def check_telemetry(self) -> None:
        """Checks told angles against limits, closure and the path."""
        told = self.told
        told.telemetry += 1
        knot = told.place[0]
        for group, angle in enumerate(told.angles):
            low, high = self.path.limits[group][:2]
            if not low - 1e-6 <= angle <= high + 1e-6:
                told.wrong.append(f"group {group} is told at {angle}, beyond its limits")
        told.largest_closure = max([told.largest_closure, *residuals(self.path, told.angles)])
        if told.largest_closure > self.path.closure * 17 / 16 + 2e-6:
            told.wrong.append(f"a vertex is open by {told.largest_closure} at knot {told.place}")
        if told.place != self.beginning and knot < len(self.path.knots):
            off = max(abs(a - b) for a, b in zip(told.angles, angles_on(self.path, *told.place)))
            told.off_path = max(told.off_path, off)
            if off > 1e-5:
                told.wrong.append(f"the sheet is told {off} off the path at {told.place}")
        resting = told.state == "Holding" and told.rate == 0 and told.before == told.angles
        self.rested = self.rested + 1 if resting else 0

    # -- what is sent

    def holding(self) -> bool:
        """Tells whether a Hold waits for its answer, so that nothing else is sent."""
        return self.command == ("Hold",)

    def say(self, command: str, now: float) -> None:
        """Sends a command for the first time."""
        self.number, self.command, self.command_sent = (self.number + 1) % 256, (command,), Sent(now, now)
        self.send(("Command", self.number, self.command))

    def tick(self, now: float) -> None:
        """Sends all that is due."""
        if not self.begun and now - self.began > 5 or self.silent_since and now - self.silent_since > 5:
            raise Finished("silent", "the controller does not answer")
        if not self.begun:
            self.greet(now)
        if not self.session:
            return
        if self.command and now - self.command_sent.last >= self.retry.seconds():
            self.retry.repeats += 1
            self.sent_again += 1
            self.command_sent.last, self.command_sent.times = now, self.command_sent.times + 1
            self.send(("Command", self.number, self.command))
        if self.holding():
            return
        self.send_items(now)
        self.steer(now)
        if not self.holding():
            wait = 0.2 if self.last_counted >= self.last_sent else min(self.retry.seconds(), 0.05)
            if now - self.last_sent >= wait:
                self.send(("Alive",))

    def greet(self, now: float) -> None:
        """Greets, until a session was offered, and again if nothing comes in it."""
        keyed = self.protection.key is not None
        due = now - self.heard > 0.5 and keyed if self.session else True
        if due and now - self.hello >= self.retry.seconds():
            self.retry.repeats += self.hello > 0
            self.hello = now
            self.send(("Hello", VERSION, SCHEMA, self.id), 0)

    def send_items(self, now: float) -> None:
        """Sends items into the window, and again what was not acknowledged in time."""
        if self.base < self.next and now - max(self.trips[self.base].last, self.progress) >= self.retry.seconds():
            self.retry.repeats += 1
            self.next = self.base
        behind, seen = 0, False
        for number in range(self.base, min(self.limit, len(self.items))):
            message = ("Item", number % 65536, self.items[number])
            size = len(stuff(self.protection_size(message)))
            behind += size if number > self.base else 0
            if behind > self.retry.window:
                return
            if number < self.next:
                continue
            if self.seen and not seen:
                seen = True
                self.send(self.seen)
            self.send(message)
            if number in self.trips:
                self.sent_again += 1
                self.trips[number].last, self.trips[number].times = now, self.trips[number].times + 1
            else:
                self.trips[number] = Sent(now, now)
            self.next, self.high = number + 1, max(self.high, number + 1)

    def protection_size(self, message: tuple) -> bytes:
        """Makes bytes as long as the frame of a message, to count them."""
        return bytes(5) + encode("host", message) + bytes(4 if self.protection.key is None else 13)

    # -- the course of a run

    def answered(self, command: str, denial: tuple | None, now: float) -> None:
        """Goes on after the answer to a command."""
        if denial and command == "Start" and denial[0] == "Unknown" and now - self.began < 10:
            self.phase, self.pause = "load", now + 0.1
        elif denial:
            raise Finished("denied", f"{command}: {denial}")
        elif command == "Start":
            self.phase = "run"
        elif command == "Hold":
            self.phase, self.rested = "rest", 0
        elif self.phase == "resume":
            self.phase = "go on"

    def steer(self, now: float) -> None:
        """Says the next command, when it is time for one."""
        if self.report is None or self.command:
            return
        state, reason = self.report[9][0], self.report[10][0]
        loaded = self.items and (self.base == len(self.items) or self.base == self.limit)
        if state == "Faulted":
            raise Finished("faulted", str(self.report[10]))
        if self.phase == "load" and loaded and now >= self.pause and state == "Ready":
            self.say("Resume" if reason in ("HoldCommand", "Underrun", "Silence", "Session", "Lag") else "Start", now)
        elif self.phase == "run" and state == "Holding" and reason not in ("Underrun", "Lag", "Lease", "None"):
            raise Finished("held", reason)
        elif self.phase == "run" and self.hold_is_due(now):
            self.options.hold_after = None
            self.say("Hold", now)
        elif self.phase == "rest" and self.rested >= 3:
            self.phase = "resume"
            self.say("Resume", now)
        elif self.phase == "go on" and reason != "HoldCommand":
            self.phase = "run"
        if self.phase != "load" and state == self.told.state == "Done" and None not in self.told.angles:
            self.check_end()
            raise Finished("done", reason)

    def hold_is_due(self, now: float) -> bool:
        """Tells whether the motion has gone on for as long as was asked."""
        after = self.options.hold_after
        return after is not None and self.motion is not None and now - self.motion >= after

    def check_end(self) -> None:
        """Checks that the last told angles are those of the last knot."""
        last = [group[0] for group in self.path.knots[-1][1]]
        if any(abs(a - b) > 1e-5 for a, b in zip(self.told.angles, last, strict=True)):
            self.told.wrong.append("the last told angles are not those of the last knot")

    def run(self) -> dict:
        """Runs to an end, and tells it."""
        try:
            while True:
                self.receive(0.002)
                self.tick(time.monotonic())
        except Finished as end:
            outcome, reason = end.args
        except OSError as error:
            outcome, reason = "lost", str(error)
        if outcome == "done" and self.options.hold_after is not None:
            self.told.wrong.append("the motion ended before it could be held")
        if self.told.wrong:
            outcome, reason = "wrong", "; ".join(self.told.wrong[:3])
        setpoints = sum(item[0] == "Setpoint" for item in self.items[:self.base])
        return {"outcome": outcome, "telemetry": self.told.telemetry, "largest_closure": self.told.largest_closure,
                "setpoints": setpoints, "sent_again": self.sent_again,
                "state": self.report[9][0] if self.report else "None", "reason": reason,
                "off_path": self.told.off_path, "measured": self.told.measured, "largest_lag": self.told.largest_lag}


# ---------------------------------------------------------------- the specification's examples

EXPECTED = """
Hello 3 305419896 5
Item 300 Sheet Hermite 2 1104 4 0.001 7 200 0.5 0.125
Item 300 Limits 00000000 0000c03f 0000003f 00000040
Item 300 Hinges 06
Item 300 Spokes 0000 0000803f 00000000
Item 300 Setpoint 300 0.5 True 0000803f 00000000
Item 300 Nodes 0000803f 00000000
Command 2 Hold
Alive
Pair 07070707070707070707070707070707
Seen 1000000 48
Mismatch 5 3 305419896
Welcome 5 6 300 4 2 1104 16 64
Unknown
Report 300 316 7 4 True None 2 None Holding StopLine 200 0.5 7 True True
Report 300 316 7 4 True Room 2 Held Holding StopLine 200 0.5 7 True True
Telemetry 1000000 Running 0.5 200 0.5 48 0000803f
Measured 1000000 300 1.5 0000803f
Measured 1000000 48 None 0000803f 0000c07f
""".strip()


def flat(value) -> list[str]:
    """Spells the parts of a value."""
    if isinstance(value, tuple):
        return [part for each in value for part in flat(each)]
    return [value.hex() if isinstance(value, bytes) else str(round(value, 6) if isinstance(value, float) else value)]


def examples(text: str) -> list[list[tuple[bytes, str]]]:
    """Finds all blocks of examples, each a list of bytes and what stands beside them."""
    out = []
    for block in re.findall(r"```hex\n(.*?)```", text, re.S):
        lines = [line.split("|", 1) for line in block.strip().splitlines()]
        out.append([(bytes.fromhex(left), right.strip()) for left, right in lines])
    return out


def check_values(lines: list[tuple[bytes, str]]) -> list[str]:
    """Decodes and encodes every message and value, and lists what differs."""
    wrong, kind, spelled = [], "host", EXPECTED.splitlines()
    for number, (data, text) in enumerate(lines):
        if text.startswith("Mismatch"):
            kind = "controller"
        for name in ("interpolation", "command", "state", "reason", "fault", "denial", "item refused",
                     "setpoint refused"):
            if re.match(rf"{name},? [A-Z]", text):
                kind, text = name.removesuffix(" refused").replace("item", "refused"), text[len(name):].lstrip(", ")
        try:
            value = decode(kind, data)
        except Bad as error:
            wrong.append(f"{text}: {error}")
            continue
        if encode(kind, value) != data:
            wrong.append(f"{text}: encoded as {encode(kind, value).hex(' ')}")
        if number < len(spelled) and "".join(flat(value)) != spelled[number].replace(" ", ""):
            wrong.append(f"{text}: read as {flat(value)}")
        if kind not in ("host", "controller") and not text.startswith(value[0]):
            wrong.append(f"{text}: read as {value}")
    return wrong


def check_keys(lines: list[tuple[bytes, str]]) -> list[str]:
    """Makes all frames and keys of the example with a key, and lists what differs."""
    data = [line[0] for line in lines]
    nonce, wrong = 0x0000000900000005, []
    ours = Protection(data[0], nonce)
    made = [data[0], session_key(data[0], 1, 0, 0, 0), ours.seal(0, encode("host", ("Hello", 3, 0x12345678, 5))),
            session_key(data[0], 2, 0, 0, 0), data[4]]
    session, message = ours.open(data[4])
    if session or decode("controller", message)[2:5] != (6, 300, 4):
        wrong.append("Welcome with a key")
    ours.offer(6, 300, 4)
    made += [session_key(data[0], 1, nonce, 300, 6), ours.seal(6, encode("host", ("Command", 1, ("Start",)))),
             session_key(data[0], 2, nonce, 300, 6)]
    return wrong + [lines[i][1] for i in range(len(data)) if data[i] != made[i]]


def self_test(text: str) -> list[str]:
    """Checks everything that the specification shows, and lists what differs."""
    file, command, values, keys = examples(text)
    whole = b"".join(line[0] for line in file)
    path = read_path(whole)
    wrong = [] if f"number `{path_number(path):08x}`" in text else [f"number of the path: {path_number(path):08x}"]
    for at in range(len(whole)):
        try:
            read_path(whole[:at] + bytes([whole[at] ^ 1]) + whole[at + 1:])
            wrong.append(f"byte {at} was changed and taken")
        except Bad:
            pass
    frame = b"".join(line[0] for line in command)
    made = stuff(Protection(None, 5).seal(6, encode("host", ("Command", 1, ("Start",)))))
    if made != frame or unstuff(frame[:-1]) != Protection(None, 5).seal(6, b"\2\1\0"):
        wrong.append(f"frame of Command: {made.hex(' ')}")
    schema = zlib.crc32(b"".join(line[0] for line in values))
    if schema != SCHEMA:
        wrong.append(f"schema: {schema:08x}")
    for size in (0, 1, 253, 254, 255, 508, 600):
        for data in (bytes(size), b"\1" * size, b"\1" * size + b"\0", (b"\1" * 254 + b"\0") * 2 + bytes(size)):
            if unstuff(stuff(data)[:-1]) != data or 0 in stuff(data)[:-1]:
                wrong.append(f"stuffing of {size} bytes")
    return wrong + check_values(values) + check_keys(keys)


def main() -> int:
    """Reads the arguments and does what they ask."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("path", help="a .traj file, or the specification with --self-test")
    parser.add_argument("address", nargs="?", help="HOST:PORT of the controller")
    parser.add_argument("--key", help="file of 32 hexadecimal digits")
    parser.add_argument("--hold-after", type=float, help="hold so many seconds after the motion began, then go on")
    parser.add_argument("--drop", type=float, default=0.0, help="fraction of frames to lose in both directions")
    parser.add_argument("--seed", type=int, default=0, help="seed of the losses")
    parser.add_argument("--self-test", action="store_true", help="check the examples of the specification")
    options = parser.parse_args()
    with open(options.path, "rb") as file:
        data = file.read()
    if options.self_test:
        wrong = self_test(data.decode())
        print("\n".join(wrong) or "every example is as the specification says")
        return bool(wrong)
    try:
        path = read_path(data)
    except Bad as error:
        print(f"{options.path}: {error}", file=sys.stderr)
        return 2
    key = None
    if options.key:
        with open(options.key, encoding="ascii") as file:
            key = bytes.fromhex(file.read().strip())
        require(len(key) == 16, "a key has 32 hexadecimal digits")
    if not options.address or ":" not in options.address:
        parser.error("expected HOST:PORT")
    host, port = options.address.rsplit(":", 1)
    with socket.create_connection((host, int(port)), 5) as link:
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        answer = Host(path, link, key, options).run()
    print(json.dumps(answer))
    return answer["outcome"] != "done"


if __name__ == "__main__":
    sys.exit(main())
