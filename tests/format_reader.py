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

LIMIT, U32, U64 = 1 << 27, (1 << 32) - 1, (1 << 64) - 1


def require(condition, what):
    if not condition:
        raise ValueError(what)

# ---- "Container" and "Chunks"

def chunks(data):
    """Yields (type, critical, payload) up to the first chunk that is not whole."""
    require(data[:8] == b"\x89BOZ\r\n\x1a\n", "not a wavelet file")
    version, zero, crc = struct.unpack_from("<HHI", data, 8)
    require(version in (2, 3) and zero == 0 and crc == zlib.crc32(data[:12]), "the version is not known or damaged")
    start = 16
    while start < len(data):
        at, lengths = start + 5, []
        while len(lengths) < 1 + (at <= len(data) and data[start + 4] >> 1 & 1):
            length = shift = 0
            while at < len(data) and data[at] > 127:
                length, shift, at = length | (data[at] & 127) << shift, shift + 7, at + 1
            if at >= len(data):
                return
            lengths.append(length | data[at] << shift)
            at += 1
        fields, end = data[start:at], at + 2 + lengths[0] + 4
        if at + 2 > len(data):
            return
        require(data[at:at + 2] == struct.pack("<I", zlib.crc32(fields))[:2], f"byte {start}: the header's checksum")
        if end > len(data):
            return
        payload = data[at + 2:end - 4]
        require(struct.unpack_from("<I", data, end - 4)[0] == zlib.crc32(fields + payload), f"byte {start}: checksum")
        require(fields[4] < 4, f"byte {start}: a newer version's chunk")
        payload = zlib.decompress(payload, -15) if len(lengths) > 1 else payload
        require(len(payload) == lengths[-1], f"byte {start}: lengths do not agree")
        yield fields[:4], fields[4] & 1 == 1, payload
        start = end


class Header:
    def __init__(self, data, version):
        self.transform, data = (data[0], data[1:]) if version == 3 else (0, data)
        self.in_lanes, self.transform = self.transform & 8 > 0, self.transform & ~8
        require(self.transform <= 4, "unknown transform")
        self.scheme, self.wavelet, self.levels, self.precision, self.up, count = struct.unpack_from("<6B", data)
        texts, at = [], 6
        for _ in range(count + 1):
            texts.append(data[at + 1:at + 1 + data[at]].decode())
            at += 1 + data[at]
        *self.channels, self.unit = texts
        numbers = "<4f" if data[at] else "<4d"
        *self.origin, self.step = struct.unpack_from(numbers, data, at + 1)
        at += 1 + struct.calcsize(numbers)
        self.vertices, self.faces = struct.unpack_from("<II", data, at)
        self.hash = data[at + 8:]
        require(self.scheme == 0 and self.wavelet <= 3 and self.up <= 2, "unknown scheme, wavelet or axis")
        require(self.levels <= 15 and 8 <= self.precision <= 25, "levels or precision out of range")
        require(self.channels == ["x", "y", "z"] and len(self.hash) == 16, "unknown channels or wrong length")

# ---- "Range coder"

class Missing(Exception):
    """A bit that is not there."""


class RangeDecoder:
    def __init__(self, data):
        self.data = data
        self.begin(0)

    def begin(self, at):
        self.at, self.range = at + 4, U32
        self.code = int.from_bytes(self.data[at:at + 4].ljust(4, b"\0"), "big")

    def normalise(self):
        while self.range < 1 << 24:
            self.range <<= 8
            self.code = self.code << 8 & U32 | (self.data[self.at] if self.at < len(self.data) else 0)
            self.at += 1

    def bit(self, model):
        bound = (self.range >> 16) * max(64, min(65472, model[0]))
        bit = self.code < bound
        if bit:
            self.range = bound
        else:
            self.code, self.range = self.code - bound, self.range - bound
        model[0] += ((65535 if bit else 0) - model[0]) * (65536 // (model[1] + 2)) >> 16
        model[1] = min(model[1] + 1, 126)
        self.normalise()
        return bit

    def raw(self, count):
        if count > 16:
            return self.raw(count - 16) << 16 | self.raw(16)
        self.range >>= count
        value = min(self.code // self.range, (1 << count) - 1)
        self.code -= value * self.range
        self.normalise()
        return value

    def check(self):
        if self.at > len(self.data):
            raise Missing

# ---- "Lanes"

def kinds(weights):
    """A model: where each kind's share begins, and how much it has learnt."""
    return [[k + sum(weights[:k]) * 32752 // sum(weights) for k in range(16)], 0]


class LaneDecoder:
    def __init__(self, data, at):
        self.data, self.at = data, at
        self.begin()

    def word(self):
        word = int.from_bytes(self.data[self.at:self.at + 4], "little") if self.at + 4 <= len(self.data) else 0
        self.at += 4
        return word

    def begin(self):
        self.states = [self.word() | self.word() << 32 for _ in range(3)]

    def renew(self, lane, state):
        self.states[lane] = state << 32 | self.word() if state < 1 << 31 else state

    def kind(self, lane, model):
        (below, seen), state = model, self.states[lane]
        place = state & 32767
        kind = max(k for k in range(16) if below[k] <= place)
        share = (below[kind + 1] if kind < 15 else 32768) - below[kind]
        self.renew(lane, share * (state >> 15) + place - below[kind] & U64)
        rate = 2 + sum(seen >= limit for limit in (2, 6, 14, 30, 63))
        for k in range(16):
            below[k] += (k if k <= kind else 32752 + k) - below[k] >> rate
        model[1] = min(seen + 1, 63)
        return kind

    def raw(self, lane, count):
        state = self.states[lane]
        self.renew(lane, state >> count)
        return state & (1 << count) - 1

    check = RangeDecoder.check

# ---- "Base connectivity"

def base_mesh(data, vertices, count):
    """Faces and sharp edges."""
    coder, faces, told, used, queue = RangeDecoder(data), [], set(), set(), []
    is_open, lowest, number_bits = {}, [0], max(vertices - 1, 0).bit_length()
    face_model, lowest_model = [65000, 4], [32768, 0]
    answers = [[[32768, 0] for _ in range(3)] for _ in range(4)]

    def number():
        return coder.raw(number_bits)

    def unused():
        while lowest[0] in used:
            lowest[0] += 1
        v = lowest[0] if coder.bit(lowest_model) else number()
        used.add(v)
        return v

    def third(a, b):
        x = next((end for start, end in reversed(is_open) if start == b), None)
        y = next((start for start, end in reversed(is_open) if end == a), None)
        context = 3 if x is not None and x == y else (x is not None) + (y is not None)
        if coder.bit(answers[context][0]):
            return unused()
        if x is not None and coder.bit(answers[context][1]):
            return x
        if y is not None and x != y and coder.bit(answers[context][2]):
            return y
        return number()

    while len(faces) < count:
        if queue:
            a, b = queue.pop(0)
            if (a, b) in told:
                continue
            is_open.pop((a, b), None)
            if not coder.bit(face_model):
                coder.check()
                continue
            face = (a, b, third(a, b))
        else:
            face = tuple(unused() if coder.bit(answers[0][0]) else number() for _ in range(3))
        coder.check()
        require(len(set(face)) == 3 and max(face) < vertices, "a base face that is none")
        for k in range(3):
            v, w = face[k], face[(k + 1) % 3]
            require((v, w) not in told, "an edge told twice")
            told.add((v, w))
            is_open.pop((v, w), None)
            if (w, v) not in told:
                is_open[w, v] = True
                queue.append((w, v))
        faces.append(face)
    faces = sorted(face[k:] + face[:k] for face in faces for k in [face.index(min(face))])
    model, sharp = [32768, 0], []
    if coder.raw(1):
        sharp = [e for e in sorted({tuple(sorted(e)) for e in told}) if coder.bit(model)]
    coder.check()
    return faces, sharp

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


def synthesise(base, j, coarser, details, wavelet, has_bends=False):
    """c^j and d^j to c^{j+1}, all by id."""
    parents, level = odd_parents(base, j), Level(base, j)
    update = updates(level, parents, details, wavelet)
    finer = {v: [wrap(c - x) for c, x in zip(value, update.get(v, (0, 0, 0)))] for v, value in coarser.items()}
    bend = bends(base, j, level, parents, finer) if has_bends else defaultdict(lambda: (0, 0, 0))
    for i, (u, w) in parents.items():
        finer[i] = [wrap(d + ((a + b) >> 1) + x) for d, a, b, x in zip(details[i], finer[u], finer[w], bend[i])]
    return finer


def analyse(base, finest, levels, wavelet):
    """c^J to the surface's own coefficients by id: c^0 and every d^j; and whether all on the way is within the limit."""
    found, within = dict(finest), True
    for j in reversed(range(levels)):
        parents = odd_parents(base, j)
        for i, (u, w) in parents.items():
            found[i] = [wrap(c - ((a + b) >> 1)) for c, a, b in zip(found[i], found[u], found[w])]
        for v, update in updates(Level(base, j), parents, found, wavelet).items():
            found[v] = [wrap(c + x) for c, x in zip(found[v], update)]
        within = within and all(abs(x) <= LIMIT for d in found.values() for x in d)
    return {i: tuple(d) for i, d in found.items()}, within

# ---- "Transforms"

def flaps(level, parents, positions, curve=()):
    """F of the edge that each odd vertex halves."""
    found = {}
    for i, (u, w) in parents.items():
        beside = level.opposite[u, w]
        inner = len(beside) == 2 and (u, w) not in curve
        a, b = (positions[x] for x in beside) if inner else (positions[u], positions[w])
        found[i] = [a[c] + b[c] - positions[u][c] - positions[w][c] for c in range(3)]
    return found


def odd_neighbours(base, j, parents):
    return {i: [x for x in around if x in parents] for i, around in Level(base, j + 1).neighbours.items() if i in parents}


def sixteenth(sums):
    return [wrap(8 - sum(x)) >> 4 for x in zip((0, 0, 0), *sums)]


def bends(base, j, level, parents, positions):
    """B of every odd vertex, curves kept."""
    curve = {edge for edge, beside in level.opposite.items() if len(beside) == 1}
    curve |= {(u, w) for u, around in level.sharp.items() for w in around}
    ends = defaultdict(list)
    for u, w in curve:
        ends[u].append(w)
    F, near = flaps(level, parents, positions, curve), odd_neighbours(base, j, parents)

    def H(v):
        if len(ends[v]) != 2:
            return (0, 0, 0)
        a, b = ends[v]
        return [positions[a][c] + positions[b][c] - 2 * positions[v][c] for c in range(3)]

    return {i: sixteenth([H(u), H(w)] if (u, w) in curve else [F[x] for x in near[i]]) for i, (u, w) in parents.items()}

# ---- "Stream"

def quotient(x, y):
    return x // y if (x < 0) == (y < 0) else -(-x // y)


class Frame:
    def __init__(self, normal):
        self.a = max(range(3), key=lambda c: abs(normal[c]))
        most = abs(normal[self.a])
        self.p = self.q = self.P = self.Q = 0
        self.reversed = normal[self.a] < 0
        if most:
            shift = max(most.bit_length() - 31, 0)
            a, b, c = (normal[(self.a + k) % 3] >> shift for k in range(3))
            self.p, self.q = quotient(b << 14, a), quotient(c << 14, a)
            square = (1 << 28) + self.p * self.p + self.q * self.q
            self.P, self.Q = quotient(self.p << 28, square), quotient(self.q << 28, square)

    def turn(self, d):
        a, b, c = (d[(self.a + k) % 3] for k in range(3))
        half = 1 << 13
        normal = wrap(a + (self.p * b + self.q * c + half >> 14))
        b, c = wrap(b - (self.P * normal + half >> 14)), wrap(c - (self.Q * normal + half >> 14))
        return (wrap(-normal) if self.reversed else normal, b, c)

    def back(self, normal, b, c):
        normal, half = -normal if self.reversed else normal, 1 << 13
        b = wrap(b + (self.P * normal + half >> 14))
        c = wrap(c + (self.Q * normal + half >> 14))
        d = {self.a: wrap(normal - (self.p * b + self.q * c + half >> 14)), (self.a + 1) % 3: b, (self.a + 2) % 3: c}
        return (d[0], d[1], d[2])


def restored(x, plane):
    middle = (7 << plane) >> 4
    return x + middle if x > 0 else x - middle if x < 0 else 0


class Stream:
    NEAR = [0, 1, 2, 3, 4, 4, 5, 5, 5] + [6] * 5 + [7] * 12 + [8] * 37 + [9]

    def __init__(self, head, base, data):
        self.head, self.base, self.coder = head, base, RangeDecoder(data)
        levels, models = range(head.levels), lambda one, seen, *sizes: (
            [models(one, seen, *sizes[1:]) for _ in range(sizes[0])] if sizes else [one, seen])
        self.parents = [odd_parents(base, j) for j in levels]
        self.known, self.frames, self.planes = [None] * head.levels, [None] * head.levels, []
        # By class: the plane of each vertex, where a block was cut.
        self.above = [[{}, {}] for _ in levels]
        self.near = [None] * head.levels
        first = ([1000, 5000, 8000, 11000, 14000, 18000, 22000, 26000, 30000, 32000],
                 [0, 700, 1500, 3000, 6000, 10000, 13000], [0, 1500, 3000, 6000, 9000])
        self.significant = [[[[[min(32768, a + b + c), 2] for c in first[2]] for b in first[1]] for a in first[0]]
                            for _ in range(2)]
        self.taken, self.more, self.finishing = models(62000, 8, 4), [8000, 2], [2000, 4]
        self.positions, self.signs = models(32768, 0, 3, 33), models(32768, 4, 5)
        self.length, self.second = models(22000, 2, 2, 10, 12), models(28000, 4, 2, 12)
        self.refined = models(28000, 4, 2)
        # By level: how far parts are from their predictions, where the level is finished.
        self.residuals = [None] * head.levels
        likely = lambda e, i: [8000, 20000, 38000, 54000, 61000][max(0, min(4, max(0, e // 2 - 3) + 2 - i))]
        self.length_r = [[[[likely(e, i), 1] for i in range(33)] for e in range(40)] for _ in range(2)]
        self.second_r = models(28000, 4, 2, 33)
        self.refined_r = [[[one, 2] for one in (8000, 16000, 26000, 36000, 46000, 50000)] for _ in range(2)]
        first = [1900, 2700, 3800, 5400, 7600, 10500, 14000, 16000, 13500, 8400, 4200, 1900, 800, 320, 130, 50, 20, 8, 3]
        likely = lambda e, k: (first + 5 * [1])[min(23, k + 15 - e + 2 * max(0, e // 2 - 7))]
        self.size_l = [[kinds([likely(e, k) for k in range(16)]) for e in range(40)] for _ in range(2)]
        self.refined_l = [[[kinds([int(k < 2 << t) for k in range(16)]) for t in range(4)] for _ in range(6)]
                          for _ in range(2)]
        self.beginning()
        try:
            while self.step():
                pass
        except Missing:
            pass

    def beginning(self):
        coder, self.c0 = self.coder, []
        self.plane = min(coder.raw(5), 30)
        lower = defaultdict(list)
        for low, high in self.base.edges:
            lower[high].append(low)
        for v in range(self.head.vertices):
            expected = [sum(self.c0[w][c] >> self.plane for w in lower[v]) // len(lower[v]) if lower[v]
                        else self.c0[v - 1][c] >> self.plane if v else 0 for c in range(3)]
            self.c0.append([wrap(wrap(e + self.signed(c)) << self.plane) for c, e in enumerate(expected)])
            coder.check()
        self.base_planes = [self.plane] * self.head.vertices
        for _ in range(self.head.levels):
            plane = min(coder.raw(5), 30)
            self.planes.append([plane, plane])
        coder.check()

    def signed(self, axis):
        length = 0
        while length < 32 and self.coder.bit(self.positions[axis][length]):
            length += 1
        if not length:
            return 0
        u = 1 << (length - 1) | self.coder.raw(length - 1)
        return u // 2 if u % 2 == 0 else -((u + 1) // 2)

    def step(self):
        steps = [(8 * self.plane, None, None, self.plane)]
        for j, planes in enumerate(self.planes):
            if self.known[j] is None:
                steps.append((8 * planes[0] - 8 * j - 12, j, None, planes[0]))
            else:
                steps += [(8 * plane - 8 * j - 12 * k, j, k, plane) for k, plane in enumerate(planes)]
        steps = sorted((step for step in steps if step[3] > 0), key=lambda step: -step[0])
        if not steps:
            return False
        coder, at = self.coder, 0
        while at + 1 < len(steps) and not coder.bit(self.taken[min(at, 3)]):
            at += 1
        _, j, k, plane = steps[at]
        count, finish = 1, k is not None and coder.bit(self.finishing)
        while not finish and (j is None or k is not None) and count < plane and coder.bit(self.more):
            count += 1
        coder.check()
        if j is None:
            self.plane -= count
            for v, position in enumerate(self.c0):
                more = [coder.raw(count) << self.plane for _ in range(3)]
                coder.check()
                self.c0[v], self.base_planes[v] = [x | y for x, y in zip(position, more)], self.plane
        elif k is None:
            self.begin(j)
        elif finish:
            self.finish(j)
        else:
            self.block(j, k, plane, plane - count)
        return True

    def begin(self, j):
        level, positions = Level(self.base, j), self.known_positions(j)
        normals = defaultdict(lambda: [0, 0, 0])
        for face in level.faces:
            a, b, c = (positions[v] for v in face)
            p, q = [x - y for x, y in zip(b, a)], [x - y for x, y in zip(c, a)]
            cross = [p[k - 2] * q[k - 1] - p[k - 1] * q[k - 2] for k in range(3)]
            for v in face:
                normals[v] = [x + y for x, y in zip(normals[v], cross)]
        signed = lambda x: (x + (1 << 63) & U64) - (1 << 63)
        self.frames[j] = {i: Frame([signed(x + y) for x, y in zip(normals[u], normals[w])])
                          for i, (u, w) in self.parents[j].items()}
        odd = self.parents[j]
        self.near[j] = odd_neighbours(self.base, j, odd)
        self.known[j] = {i: [0, 0, 0] for i in sorted(odd)}
        most = self.planes[j][0]
        self.planes[j] = [max(most - self.coder.raw(5), 0) for _ in range(2)]
        self.coder.check()

    def block(self, j, k, plane, to):
        known, before = self.known[j], self.known[j - 1] if j else None
        self.planes[j][k] = to
        self.above[j][k] = dict.fromkeys(known, plane)
        size = (lambda x: abs(x[0])) if k == 0 else (lambda x: abs(x[1]) + abs(x[2]))
        for i, parts in known.items():
            near = sum(size(known[x]) for x in self.near[j][i]) >> to
            sign = max(-2, min(2, sum((known[x][0] > 0) - (known[x][0] < 0) for x in self.near[j][i])))
            parent = sum(size(before[x]) for x in self.parents[j][i] if x in before) >> to if before else 0
            new = list(parts)
            for c in [[0], [1, 2]][k]:
                own = (abs(new[0]) >> to + 1) * (c > 0) + 2 * (abs(new[1]) >> to) * (c > 1)
                new[c] = self.part(k, plane, to, (min(near, 63), parent, own, sign), new[c])
            self.coder.check()
            known[i] = new
            del self.above[j][k][i]

    def part(self, k, plane, to, context, x):
        coder, count = self.coder, plane - to
        near, parent, own, sign = context
        near, parent, own = self.NEAR[near], min(parent.bit_length(), 6), min(own.bit_length(), 4)
        if x:
            if abs(x) >> plane == 1:
                low = coder.bit(self.refined[k]) << (count - 1)
                low |= coder.raw(count - 1)
            else:
                low = coder.raw(count)
            return x + (low << to) if x > 0 else x - (low << to)
        if not coder.bit(self.significant[k][near][parent][own]):
            return 0
        length, size = 0, 1
        while length + 1 < count and coder.bit(self.length[k][near][min(length, 11)]):
            length += 1
        if length:
            size = 2 | coder.bit(self.second[k][min(length, 11)])
            size = size << (length - 1) | coder.raw(length - 1)
        negative = coder.bit(self.signs[sign + 2]) if k == 0 else coder.raw(1)
        return -(size << to) if negative else size << to

    def predictions(self, j):
        if self.head.transform:
            return dict.fromkeys(self.parents[j], (0, 0, 0))
        F = flaps(Level(self.base, j), self.parents[j], self.known_positions(j))
        return {i: self.frames[j][i].turn(sixteenth([F[x] for x in self.near[j][i]])) for i in self.parents[j]}

    def finish(self, j):
        predicted, known, planes = self.predictions(j), self.known[j], self.planes[j]
        before = self.residuals[j - 1] if j else None
        residuals = self.residuals[j] = dict.fromkeys(known, (0, 0, 0))
        self.planes[j], self.above[j] = [0, 0], [dict.fromkeys(known, plane) for plane in planes]
        sizes = lambda parts: (abs(parts[0]), abs(parts[1]) + abs(parts[2]))
        in_lanes = self.head.in_lanes and len(known) >= 4096
        coder = LaneDecoder(self.coder.data, self.coder.at) if in_lanes else self.coder
        for number, (i, parts) in enumerate(known.items()):
            if in_lanes and number and number % 16384 == 0:
                coder.begin()
            near = [residuals[x] for x in self.near[j][i]]
            above = [before[x] for x in self.parents[j][i] if x in before] if before else []
            new, off = list(parts), [0, 0, 0]
            for c in range(3):
                k = min(c, 1)
                sums = [sum(sizes(parts)[k] for parts in group) for group in (near, above, [predicted[i]])]
                own = (0, abs(off[0]), (abs(off[0]) >> 1) + abs(off[1]))[c]
                expected = 4 * sums[0] + sums[1] + (4 if k else 2) * sums[2] + 4 * own >> k
                at = wrap(predicted[i][c] + (5 * sum(parts[c] for parts in near) >> 4))
                if planes[k] and in_lanes:
                    new[c] = self.corrected_in_lane(coder, c, planes[k], expected, at, new[c])
                elif planes[k]:
                    new[c] = self.corrected(k, planes[k], expected, at, new[c])
                off[c] = wrap(new[c] - at)
            coder.check()
            known[i], residuals[i] = new, off
            del self.above[j][0][i], self.above[j][1][i]
        if in_lanes:
            self.coder.begin(coder.at)

    def corrected_in_lane(self, coder, lane, plane, expected, at, x):
        k, bits = min(lane, 1), expected.bit_length()
        if x:
            place = max(-1, min(4, 4 * ((-at if x < 0 else at) - abs(x)) >> plane))
            top = min(plane, 4)
            low = coder.kind(lane, self.refined_l[k][place + 1][top - 1]) % (1 << top) << (plane - top)
            low |= coder.raw(lane, plane - top)
            return x + low if x > 0 else x - low
        context = expected if bits < 2 else min(39, 2 * bits - 2 + (expected >> (bits - 2) & 1))
        at, shift = max(1 - (1 << plane), min((1 << plane) - 1, at)), max(0, context // 2 - 7)
        kind = coder.kind(lane, self.size_l[k][context])
        of = kind if kind < 15 else min(63, 15 + coder.raw(lane, 6))
        least, below = (of, 0) if of < 2 else ((2 | of & 1) << (of // 2 - 1), of // 2 - 1)
        count = below + shift + 1 if of or shift else 0
        tail = coder.raw(lane, min(31, count))
        if kind == 15:
            tail |= coder.raw(lane, max(0, count - 31)) << 31
        size = wrap((least << shift) + (tail >> 1))
        return wrap(at - size if tail & 1 else at + size)

    def corrected(self, k, plane, expected, at, x):
        coder, bits = self.coder, expected.bit_length()
        if x:
            along = -at if x < 0 else at
            place = max(-1, min(4, 4 * (along - abs(x)) >> plane))
            low = coder.bit(self.refined_r[k][place + 1]) << (plane - 1)
            low |= coder.raw(plane - 1)
            return x + low if x > 0 else x - low
        context = expected if bits < 2 else min(39, 2 * bits - 2 + (expected >> (bits - 2) & 1))
        at = max(1 - (1 << plane), min((1 << plane) - 1, at))
        length = 0
        while length < 32 and coder.bit(self.length_r[k][context][length]):
            length += 1
        if not length:
            return at
        left = length - 1
        size = 1 << left
        if left:
            left -= 1
            size |= coder.bit(self.second_r[k][length]) << left
        tail = coder.raw(left + 1)
        size |= tail >> 1
        return wrap(at - size if tail & 1 else at + size)

    def known_base(self):
        return {v: tuple(wrap(x + (1 << plane >> 1)) for x in position)
                for v, (position, plane) in enumerate(zip(self.c0, self.base_planes))}

    def known_details(self, j):
        if self.known[j] is None:
            return dict.fromkeys(self.parents[j], (0, 0, 0))
        planes, above = self.planes[j], self.above[j]
        return {i: self.frames[j][i].back(*(
            restored(x, above[c > 0].get(i, planes[c > 0])) for c, x in enumerate(parts)))
            for i, parts in self.known[j].items()}

    def known_positions(self, level):
        positions = self.known_base()
        for j in range(level):
            wavelet = self.head.transform - 1 if self.head.transform else self.head.wavelet
            positions = synthesise(self.base, j, positions, self.known_details(j), wavelet, self.head.transform > 0)
        return positions

    def coefficients(self):
        """All coefficients by id, and whether every bit of them is known."""
        exact = self.plane == 0 and all(plane == 0 for planes in self.planes for plane in planes) and not any(
            above for level in self.above for above in level)
        require(not exact or self.coder.at >= len(self.coder.data), "the stream goes on after its end")
        clamped = lambda all: {i: tuple(max(-LIMIT, min(LIMIT, x)) for x in d) for i, d in all.items()}
        if self.head.transform == 0:
            found = self.known_base()
            for j in range(self.head.levels):
                found.update(self.known_details(j))
            found = found if exact else clamped(found)
        else:
            found = self.known_positions(self.head.levels)
            found, within = analyse(self.base, found if exact else clamped(found), self.head.levels, self.head.wavelet)
            found = found if exact or within else clamped(found)
        require(all(abs(x) <= LIMIT for d in found.values() for x in d), "a coefficient beyond the limit")
        return found

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
            require(not complete and kind in (b"HEAD", b"BASE", b"WAVE", b"END!"), f"unexpected {kind}")
            complete = kind == b"END!"
            critical.append((kind, payload))
        elif complete:
            beside[kind] = payload
    require([kind for kind, _ in critical[:3]] == [b"HEAD", b"BASE", b"WAVE"], "the base mesh is not complete")
    head = Header(critical[0][1], data[8])
    base = Base(head.vertices, *base_mesh(critical[1][1], head.vertices, head.faces))
    stream = b""
    for kind, payload in critical[2:]:
        require(kind == (b"WAVE" if payload else b"END!"), f"unexpected {kind}")
        error, = struct.unpack("<f", b"\0\0" + payload[:2]) if payload else (0,)
        require(0 <= error < math.inf, "a stated error is no distance")
        stream += payload[2:]
    coefficients = Stream(head, base, stream).coefficients()
    require(b"SRCE" not in beside or len(beside[b"SRCE"]) == 4 * len(coefficients), "source indices do not fit")
    json.loads(beside.get(b"META", b"{}"))
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
