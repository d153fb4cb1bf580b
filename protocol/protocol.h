/* protocol: what the daemon and its clients say, and the client's side of it.
 *
 * The messages are in fovea.proto (protobuf); this header has the framing, the tile encodings, and the client
 * library on which foveactl and viewers are built. It knows nothing of rendering or gaze devices.
 *
 * Errors are one line of text in a caller's buffer of PRO_ERROR_SIZE bytes. Bytes from a peer are never
 * trusted: every length is checked before it is used, and nothing is allocated beyond the limits below.
 */
#ifndef FOVEAD_PROTOCOL_H
#define FOVEAD_PROTOCOL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "fovea.pb-c.h"

PROTOBUF_C__BEGIN_DECLS

enum {
    PRO_ERROR_SIZE = 512,
    PRO_VERSION = 1,
    PRO_MAX_TO_DAEMON = 64 << 10, /* longest frame a client may send, bytes without the length */
    PRO_MAX_TO_CLIENT = 8 << 20,  /* longest frame the daemon may send */
    PRO_CHUNK = 64 << 10,         /* most bytes to give a reader at a time */
    PRO_PREFIX = 4,               /* bytes of the length before a message in a frame: big-endian */
    PRO_MAX_TILE = 256,           /* pixels a side */
    PRO_MAX_WIDTH = 65536,        /* pixels of a film, and of its height */
    PRO_MAX_PIXELS = 1 << 29,     /* of a film in all */
};

/* --- messages --- */

/* Unpack a message alone, without a frame. NULL with a line in out_error if the bytes do not parse, the message
 * has no known body, or memory is short. Allocates no more than count bytes and 16 KiB. The caller frees with
 * fovea__message__free_unpacked(m, NULL), and checks which side may send what and how many numbers a repeated
 * field has. */
Fovea__Message *pro_unpack_message(const uint8_t *bytes, size_t count, char out_error[PRO_ERROR_SIZE]);

/* Pack a message alone, without a frame. Returns malloc'ed bytes (the caller frees) and their count, or NULL
 * when memory is short or the message is longer than PRO_MAX_TO_CLIENT. headroom bytes are left free before
 * the message and not counted. */
uint8_t *pro_pack_message(const Fovea__Message *message, size_t headroom, size_t *out_count);

/* --- frames --- */

/* Collects bytes as they come and gives whole messages. */
struct pro_reader {
    size_t limit; /* longest frame accepted */
    size_t start; /* where the bytes held begin */
    size_t used;  /* bytes held */
    size_t size;  /* bytes allocated: they grow with what came, to no more than limit + 4 + PRO_CHUNK */
    uint8_t *bytes;
};

void pro_reader_init(struct pro_reader *reader, size_t limit);
void pro_reader_finish(struct pro_reader *reader);

/* Add count bytes from a peer. False if memory is short or more would be held than one frame and PRO_CHUNK
 * bytes after it: add PRO_CHUNK bytes at most, then take messages until PRO_MORE, and it holds. */
bool pro_reader_add(struct pro_reader *reader, const void *bytes, size_t count);

enum pro_result { PRO_MESSAGE, PRO_MORE, PRO_BROKEN };

/* Take the next message: PRO_MESSAGE with *out_message, which the caller frees with
 * fovea__message__free_unpacked(m, NULL); PRO_MORE if no whole frame is here; PRO_BROKEN with a line in
 * out_error if the peer must be dropped: a length of zero or over the limit, or bytes that
 * pro_unpack_message() refuses. A frame's length is judged as soon as its four bytes are here. */
enum pro_result pro_reader_take(struct pro_reader *reader, Fovea__Message **out_message,
                                char out_error[PRO_ERROR_SIZE]);

/* Write the length of a packed message into the PRO_PREFIX bytes that go before it in a frame. */
void pro_put_length(uint8_t out_prefix[PRO_PREFIX], size_t count);

/* Pack a message as a frame: as pro_pack_message(), with its length before it. */
uint8_t *pro_pack(const Fovea__Message *message, size_t headroom, size_t *out_count);

/* --- encodings --- */

/* Encode a tile of size x size RGB floats (linear radiance), size up to PRO_MAX_TILE. Returns malloc'ed bytes
 * (the caller frees) and their count, or NULL when memory is short, or the encoding or the size is not known.
 * NaN becomes 0; half floats are clamped to +-65504, JPEG to what a display shows, 0 to 1. Any thread. */
uint8_t *pro_encode(Fovea__Encoding encoding, const float *rgb, unsigned size, size_t *out_count);

/* Decode into size x size RGB floats, linear radiance. False, with anything in out_rgb, if the bytes are not
 * exactly such a tile of finite numbers, or memory is short. Never reads or writes outside its buffers, nor
 * allocates more than a tile of that size needs, whatever the bytes. Any thread. */
bool pro_decode(Fovea__Encoding encoding, const uint8_t *bytes, size_t count, unsigned size, float *out_rgb);

/* --- addresses --- */

/* "unix:PATH", "tcp:HOST:PORT" (HOST may be [v6]), a bare path with a '/', or NULL for the default:
 * $XDG_RUNTIME_DIR/fovead.sock, else /tmp/fovead-UID/fovead.sock, whose folder is made if it is missing.
 * False with a line in out_error also if the default's folder belongs to somebody else or others can write to
 * it. */
struct pro_address {
    bool is_unix;
    char path[108]; /* unix: fits sockaddr_un */
    char host[256]; /* tcp */
    uint16_t port;
};
bool pro_address_parse(const char *text, struct pro_address *out_address, char out_error[PRO_ERROR_SIZE]);
/* True for unix sockets and for 127.0.0.0/8, ::1 and "localhost". */
bool pro_address_is_local(const struct pro_address *address);
/* Text form, as pro_address_parse() takes it. */
void pro_address_print(const struct pro_address *address, char *out_text, size_t size);

/* For a connected TCP socket of either side: small messages go at once, and a peer that has vanished, or
 * takes nothing, breaks the connection within about a minute. */
void pro_tcp_options(int fd);

/* --- client --- */

/* A connection, used by one thread. */
struct pro_client;

/* Connect, say hello and wait for Welcome, at most timeout_ms in all (-1: for ever; the name service's own
 * time is not counted), retrying while nothing listens yet, if wait_for_daemon. The version is filled in.
 * NULL and a line in out_error on failure; if the daemon refused with a Done, its text. Who listens at a Unix
 * socket is told nothing unless that is this user, or root. */
struct pro_client *pro_connect(const struct pro_address *address, const Fovea__Hello *hello, int timeout_ms,
                               bool wait_for_daemon, char out_error[PRO_ERROR_SIZE]);
void pro_disconnect(struct pro_client *client); /* accepts NULL */

const Fovea__Welcome *pro_welcome(const struct pro_client *client);
int pro_client_fd(const struct pro_client *client); /* for poll(); owned by the client */

/* The next message, waiting at most timeout_ms (-1: for ever): PRO_MESSAGE (the caller frees), PRO_MORE on
 * timeout, PRO_BROKEN with a line in out_error when the daemon has gone or spoke nonsense. What is returned
 * is a Tile, Gaze, Stats, Done, Pong or Bye, and safe to use: a Tile has a place in the film and its pixels are in
 * the picture (unless its generation is over; the first one of a new generation has emptied it), a Gaze has 3
 * finite numbers of direction, 0 or 3 of aim and 0 or 4 of head, a Stats or Done 0 or 3 finite ones of camera,
 * text has no control characters. A tile is acknowledged before it is returned or, when more
 * messages have come in behind it, together with the next few of them: call this again until PRO_MORE. */
enum pro_result pro_receive(struct pro_client *client, int timeout_ms, Fovea__Message **out_message,
                            char out_error[PRO_ERROR_SIZE]);

/* Send a message, waiting until the socket takes it. False and a line in out_error if the connection is
 * broken, the message is longer than PRO_MAX_TO_DAEMON, or the daemon has taken nothing for ten seconds. */
bool pro_send(struct pro_client *client, const Fovea__Message *message, char out_error[PRO_ERROR_SIZE]);

/* Round trips so far: the smallest (an old one gives way, since clocks drift), and the daemon's clock minus
 * ours estimated from it (ns). False before the first Pong; pro_receive() sends Pings by itself, about one a
 * second. */
bool pro_clock(const struct pro_client *client, uint64_t *out_round_trip_ns, int64_t *out_offset_ns);

/* --- picture --- */

/* The picture that a client has put together from its tiles: for every pixel the finest level that arrived.
 * It belongs to the client and its thread, and takes memory (6 bytes a pixel) only for tiles that came. */
struct pro_picture;
const struct pro_picture *pro_picture(const struct pro_client *client);

/* Pixels of level 0 that have arrived at some level, as a share of the film. */
double pro_picture_coverage(const struct pro_picture *picture);

/* Fill width x height x RGB floats (the film's size, see Welcome), linear radiance. Where only coarse tiles
 * came, their pixels are interpolated bilinearly, across tiles of the same level and across the seam; where
 * nothing came, 0. */
void pro_picture_resolve(const struct pro_picture *picture, float *out_rgb);

PROTOBUF_C__END_DECLS

#endif
