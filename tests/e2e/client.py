#!/usr/bin/env python3
"""A client made from fovea.proto alone: client.py SOCKET FOLDER_OF_FOVEA_PB2 [WIDEST]. It receives tiles until it has the
whole coarsest level and at least a hundred tiles, and checks each of them. No level wider than WIDEST pixels may come."""
import socket
import struct
import sys

sys.path.insert(0, sys.argv[2])
import fovea_pb2 as fovea
import zstandard

daemon = socket.socket(socket.AF_UNIX)
daemon.settimeout(600)
daemon.connect(sys.argv[1])


def send(**body):
    data = fovea.Message(**body).SerializeToString()
    daemon.sendall(struct.pack(">I", len(data)) + data)


def exactly(count):
    data = b""
    while len(data) < count:
        part = daemon.recv(count - len(data))
        assert part, "the daemon closed the connection"
        data += part
    return data


def receive():
    (length,) = struct.unpack(">I", exactly(4))
    message = fovea.Message()
    message.ParseFromString(exactly(length))
    return message


widest = int(sys.argv[3]) if len(sys.argv) > 3 else 0
send(hello=fovea.Hello(version=1, client="client.py", tiles=fovea.ENCODING_HALF_ZSTD, widest=widest))
welcome = receive().welcome
size = welcome.tile_size
coarsest, tiles, serial = set(), 0, 0
across, down = (-(-n // (size << (welcome.levels - 1))) for n in (welcome.width, welcome.height))
while len(coarsest) < across * down or tiles < 100:
    message = receive()
    if message.WhichOneof("body") != "tile":
        continue
    tile = message.tile
    assert tile.serial == serial + 1 and tile.level < welcome.levels and tile.generation <= welcome.generation + 1
    pixels = zstandard.ZstdDecompressor().decompress(tile.data)
    values = struct.unpack("<%de" % (size * size * 3), pixels)
    assert all(value == value and abs(value) <= 65504 for value in values)
    assert widest == 0 or welcome.width >> tile.level <= widest
    assert tile.samples > 0 and any(value > 0 for value in values)
    if tile.level == welcome.levels - 1:
        coarsest.add((tile.x, tile.y))
    serial, tiles = tile.serial, tiles + 1
    send(acknowledge=fovea.Acknowledge(serial=serial))
print("%d tiles of %d x %d pixels, %d levels, %s" % (tiles, size, size, welcome.levels, welcome.server))
