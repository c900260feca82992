#!/usr/bin/env python3
"""A second reader of .boz files, written from docs/FORMAT.md alone: python3 format_reader.py FILE.boz [--obj OUT.obj]

Checks every checksum, synthesises all levels, prints the surface hash of what it read beside the hash the file states.
Exit status 1 if a complete file does not have its hash. Standard library alone; exact, not fast."""

import hashlib
import json
import math
import struct
import sys
import zlib
from collections import defaultdict
from fractions import Fraction

BLOCK, LIMIT, U64 = 1 << 15, 1 << 27, (1 << 64) - 1


def require(condition, what):
    if not condition:
        raise ValueError(what)

# ---- "Container" and "Chunks"

def chunks(data):
    """Yields (type, critical, payload) up to the first chunk that is not whole."""
    require(data[:8] == b"\x89BOZ\r\n\x1a\n", "not a wavelet file")
    version, zero, crc = struct.unpack_from("<HHI", data, 8)
    require(version == 1 and zero == 0 and crc == zlib.crc32(data[:12]), "the version is not known or damaged")
    at = 16
    while at + 28 <= len(data):
        fields = data[at:at + 24]
        kind, flags, packing, zero, raw_length, length, crc = struct.unpack_from("<4sBBHQQI", data, at)
        require(crc == zlib.crc32(fields), f"byte {at}: the checksum of the chunk's header does not agree")
        end = at + 28 + length
        if end + 4 > len(data):
            return
        payload = data[at + 28:end]
        require(struct.unpack_from("<I", data, end)[0] == zlib.crc32(fields + payload), f"byte {at}: checksum")
        require(flags in (0, 1) and packing in (0, 1) and zero == 0, f"byte {at}: a newer version's chunk")
        payload = zlib.decompress(payload, -15) if packing else payload
        require(len(payload) == raw_length, f"byte {at}: lengths do not agree")
        yield kind, flags == 1, payload
        at = end + 4


class Header:
    def __init__(self, data):
        self.scheme, self.wavelet, self.levels, self.precision, self.up, count = struct.unpack_from("<6B", data)
        texts, at = [], 6
        for _ in range(count + 1):
            (length,) = struct.unpack_from("<H", data, at)
            texts.append(data[at + 2:at + 2 + length].decode())
            at += 2 + length
        *self.channels, self.unit = texts
        *self.origin, self.step, self.vertices, self.faces = struct.unpack_from("<4dII", data, at)
        self.hash = data[at + 40:]
        require(self.scheme == 0 and self.wavelet <= 3 and self.up <= 2, "unknown scheme, wavelet or axis")
        require(self.levels <= 15 and 8 <= self.precision <= 25, "levels or precision out of range")
        require(self.channels == ["x", "y", "z"] and len(self.hash) == 16, "unknown channels or wrong length")


def coefficients_from(data):
    """Coefficients from byte planes."""
    count, values = len(data) // 12, []
    require(len(data) == 12 * count, "a block's length is no multiple of 12")
    for at in range(count):
        value = []
        for channel in range(3):
            word = int.from_bytes((data[(4 * channel + byte) * count + at] for byte in range(4)), "big")
            value.append(word >> 1 if word % 2 == 0 else -(word >> 1) - 1)
        require(all(abs(x) <= LIMIT for x in value), "a coefficient beyond the limit")
        values.append(tuple(value))
    return values

# ---- "Base mesh", "Hierarchy" and "Numbering"

class Base:
    def __init__(self, vertices, faces, sharp):
        self.vertices, self.faces = vertices, faces
        pairs = [[tuple(sorted((f[k], f[(k + 1) % 3]))) for k in range(3)] for f in faces]
        self.edges = sorted({pair for three in pairs for pair in three})
        number = {edge: e for e, edge in enumerate(self.edges)}
        self.face_edges = [[number[pair] for pair in three] for three in pairs]
        self.sharp = sorted(number[tuple(sorted(edge))] for edge in sharp)
        require(faces == sorted(faces) and all(f[0] == min(f) for f in faces), "base faces out of order")

    def count(self, j):
        """n_j."""
        n = 1 << j
        return self.vertices + len(self.edges) * (n - 1) + len(self.faces) * ((n - 1) * (n - 2) // 2)

    def id_on_edge(self, e, t, j):
        """The id of the point t of 0..2^j along base edge e."""
        if t in (0, 1 << j):
            return self.edges[e][t != 0]
        while t % 2 == 0:
            t, j = t // 2, j - 1
        return self.count(j - 1) + (e << (j - 1)) + (t - 1) // 2

    def id_in_face(self, f, b, j):
        """The id of the point with barycentric coordinates b, sum 2^j, in base face f."""
        if 0 in b:
            k = (b.index(0) + 1) % 3
            e = self.face_edges[f][k]
            return self.id_on_edge(e, b[(k + 1) % 3] if self.edges[e][0] == self.faces[f][k] else b[k], j)
        while all(x % 2 == 0 for x in b):
            b, j = [x // 2 for x in b], j - 1
        n, i, r = 1 << (j - 1), b[1], b[2]
        before = sum(2 * n - s - 1 if s % 2 else n - s // 2 for s in range(1, r))
        along = i - 1 if r % 2 else (i - 1) // 2
        return self.count(j - 1) + len(self.edges) * n + f * (3 * n * (n - 1) // 2) + before + along


class Level:
    """M^j by ids: faces, neighbours, sharp curves."""

    def __init__(self, base, j):
        n, self.faces = 1 << j, []
        for f in range(len(base.faces)):
            at = {(i, r): base.id_in_face(f, [n - i - r, i, r], j) for r in range(n + 1) for i in range(n + 1 - r)}
            self.faces += [(at[i, r], at[i + 1, r], at[i, r + 1]) for i, r in at if i + r < n]
            self.faces += [(at[i + 1, r], at[i + 1, r + 1], at[i, r + 1]) for i, r in at if i + r < n - 1]
        self.faces_at, self.opposite = defaultdict(int), defaultdict(list)
        self.neighbours, self.sharp = defaultdict(list), defaultdict(list)
        for face in self.faces:
            for k in range(3):
                u, w, o = face[k], face[(k + 1) % 3], face[(k + 2) % 3]
                self.faces_at[u] += 1
                self.opposite[u, w].append(o)
                self.opposite[w, u].append(o)
        for u, w in self.opposite:
            self.neighbours[u].append(w)
        for e in base.sharp:
            for t in range(n):
                u, w = base.id_on_edge(e, t, j), base.id_on_edge(e, t + 1, j)
                self.sharp[u].append(w)
                self.sharp[w].append(u)


def odd_parents(base, j):
    """The ends of the edge of M^j that each odd vertex halves: id -> (u, w)."""
    n, parents = 2 << j, {}
    for f in range(len(base.faces)):
        for b in ([n - i - r, i, r] for r in range(n + 1) for i in range(n + 1 - r)):
            odd = [c for c in range(3) if b[c] % 2]
            if odd:
                ends = [[(b[c] + (c == up) - (c == down)) // 2 for c in range(3)] for up, down in (odd, odd[::-1])]
                parents[base.id_in_face(f, b, j + 1)] = tuple(base.id_in_face(f, end, j) for end in ends)
    return parents

# ---- "Weights" and "Arithmetic"

def updated_vertices(level, u, w, k):
    """N_k of the odd vertex between u and w, as sharp curves cut it."""
    on_curve = w in level.sharp.get(u, ())
    around = level.sharp if on_curve else level.neighbours
    found = dict.fromkeys((u, w))
    for _ in range(k):
        found.update(dict.fromkeys(x for v in list(found) for x in around[v]))
    return list(found) if on_curve else [v for v in found if v not in level.sharp]


def weights(level, u, w, k):
    vertices = updated_vertices(level, u, w, k)
    size, opposite = len(vertices), level.opposite[u, w]
    matrix = [[8 * level.faces_at[a] if a == b else 4 * len(level.opposite.get((a, b), ()))
               for b in vertices] for a in vertices]
    right = [5 * len(opposite) if v in (u, w) else 2 * opposite.count(v) for v in vertices]
    lower, diagonal = [[0.0] * size for _ in range(size)], [0.0] * size
    for a in range(size):
        for b in range(a + 1):
            rest = matrix[a][b] - sum(lower[a][m] * lower[b][m] * diagonal[m] for m in range(b))
            if b < a:
                lower[a][b] = rest / diagonal[b]
        diagonal[a] = rest

    def solve(x):
        x = list(x)
        for a in range(size):
            x[a] -= sum(lower[a][m] * x[m] for m in range(a))
        for a in reversed(range(size)):
            x[a] = x[a] / diagonal[a] - sum(lower[m][a] * x[m] for m in range(a + 1, size))
        return x

    def residual(s):
        s = [Fraction(x) for x in s]
        return [right[a] - sum(matrix[a][b] * s[b] for b in range(size)) for a in range(size)]

    s = solve(right)
    s = [x + y for x, y in zip(s, solve(float(r) for r in residual(s)))]
    # The matrix has no eigenvalue below 4, so this bounds the error, and the rounding below is proved.
    bound = math.sqrt(float(sum(r * r for r in residual(s)))) / 4 * 2**20
    scaled = [x * 2**20 for x in s]
    require(all(abs(abs(x) % 1 - 0.5) > bound for x in scaled), "a weight too near a tie")
    return {v: int(math.copysign(math.floor(abs(x) + 0.5), x)) for v, x in zip(vertices, scaled)}


def wrap(x):
    return (x + (1 << 31)) % (1 << 32) - (1 << 31)


def updates(level, parents, details, wavelet):
    """The rounded sum of weights times details for every even vertex that any of them updates."""
    sums = defaultdict(lambda: [0, 0, 0])
    for i, (u, w) in parents.items() if wavelet else ():
        for v, weight in weights(level, u, w, wavelet - 1).items():
            for c in range(3):
                sums[v][c] += weight * details[i][c]
    return {v: [(x + (1 << 19)) >> 20 for x in s] for v, s in sums.items()}


def synthesise(base, j, coarser, details, wavelet):
    """c^j and d^j to c^{j+1}, all by id."""
    parents = odd_parents(base, j)
    update = updates(Level(base, j), parents, details, wavelet)
    finer = {v: [wrap(c - x) for c, x in zip(value, update.get(v, (0, 0, 0)))] for v, value in coarser.items()}
    for i, (u, w) in parents.items():
        finer[i] = [wrap(d + ((a + b) >> 1)) for d, a, b in zip(details[i], finer[u], finer[w])]
    return finer

# ---- "Surface hash"

def mix(h):
    for _ in range(2):
        h = (h ^ h >> 32) * 0xD6E8FEB86659FD93 & U64
    return h ^ h >> 32


def surface_hash(head, base, coefficients):
    unit = head.unit.encode()
    data = b"bozzetto surface 1\0" + bytes([head.scheme, head.wavelet, head.levels, head.precision, 3])
    data += b"".join(bytes([len(channel)]) + channel.encode() for channel in head.channels)
    data += struct.pack("<4dBI", *head.origin, head.step, head.up, len(unit)) + unit
    data += struct.pack("<II", base.vertices, len(base.faces))
    data += b"".join(struct.pack("<3I", *face) for face in base.faces) + struct.pack("<I", len(base.sharp))
    data += b"".join(struct.pack("<2I", *base.edges[e]) for e in base.sharp)
    sums = [0, 0]
    for vertex, (x, y, z) in coefficients.items():
        first, second = struct.unpack("<QQ", struct.pack("<iiiI", x, y, z, vertex))
        for lane, seed in enumerate((0x243F6A8885A308D3, 0x13198A2E03707344)):
            sums[lane] = sums[lane] + mix(mix(seed ^ first) ^ second) & U64
    return hashlib.sha256(data + struct.pack("<QQ", *sums)).digest()[:16]

# ---- The file

def read(data):
    """Header, base mesh, coefficients by id, whether the end marker was there."""
    critical, beside, complete = [], {}, False
    for kind, is_critical, payload in chunks(data):
        if is_critical:
            require(not complete and kind in (b"HEAD", b"BASE", b"SCAL", b"WAVE", b"END!"), f"unexpected {kind}")
            complete = kind == b"END!"
            critical.append((kind, payload))
        elif complete:
            beside[kind] = payload
    require([kind for kind, _ in critical[:3]] == [b"HEAD", b"BASE", b"SCAL"], "the base mesh is not complete")
    head = Header(critical[0][1])
    words = struct.unpack(f"<{len(critical[1][1]) // 4}I", critical[1][1])
    faces, sharp = [words[3 * f:3 * f + 3] for f in range(head.faces)], words[3 * head.faces + 1:]
    require(2 * words[3 * head.faces] == len(sharp), "the sharp edges do not fit their number")
    base = Base(head.vertices, faces, list(zip(sharp[::2], sharp[1::2])))
    coefficients = dict(enumerate(coefficients_from(critical[2][1])))
    require(len(coefficients) == head.vertices, "the base positions do not fit the base mesh")
    everything = base.count(head.levels)
    for kind, payload in critical[3:]:
        if kind == b"END!":
            require(len(coefficients) == everything and payload == head.hash, "wrong end marker")
            continue
        (j, first), have = struct.unpack_from("<B3xI", payload), len(coefficients)
        values = coefficients_from(payload[8:])
        require(kind == b"WAVE" and j < head.levels and base.count(j) + first == have, "not the block that is due")
        require(0 < len(values) <= BLOCK and have + len(values) <= base.count(j + 1), "a block of the wrong size")
        coefficients.update(enumerate(values, have))
    require(b"SRCE" not in beside or len(beside[b"SRCE"]) == 4 * everything, "source indices do not fit")
    json.loads(beside.get(b"META", b"{}"))
    coefficients.update((missing, (0, 0, 0)) for missing in range(len(coefficients), everything))
    return head, base, coefficients, complete


def main():
    require(len(sys.argv) == 2 or len(sys.argv) == 4 and sys.argv[2] == "--obj", "give FILE.boz [--obj OUT.obj]")
    with open(sys.argv[1], "rb") as file:
        head, base, coefficients, complete = read(file.read())
    positions = {v: coefficients[v] for v in range(base.vertices)}
    for j in range(head.levels):
        positions = synthesise(base, j, positions, coefficients, head.wavelet)
    found = surface_hash(head, base, coefficients)
    print(f"hash {found.hex()}\nstated {head.hash.hex()}\n{'complete' if complete else 'partial'}, {len(positions)} vertices")
    if len(sys.argv) == 4:
        with open(sys.argv[3], "w", encoding="ascii") as out:
            for v in range(len(positions)):
                out.write("v {!r} {!r} {!r}\n".format(*(o + head.step * c for o, c in zip(head.origin, positions[v]))))
            for face in Level(base, head.levels).faces:
                out.write("f {} {} {}\n".format(*(v + 1 for v in face)))
    return 1 if complete and found != head.hash else 0


if __name__ == "__main__":
    sys.exit(main())
