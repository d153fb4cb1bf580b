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

/* Unpack a message without a frame. NULL and a line in out_error if the bytes do not parse, the message has
 * no known body, or memory is short. Allocates at most count bytes and 16 KiB. The caller frees the message
 * with fovea__message__free_unpacked(m, NULL), and checks which side may send it, and how many numbers a
 * repeated field has. */
Fovea__Message *pro_unpack_message(const uint8_t *bytes, size_t count, char out_error[PRO_ERROR_SIZE]);

/* Pack a message without a frame. Returns malloc'ed bytes, which the caller frees, and their count; NULL if
 * memory is short or the message is longer than PRO_MAX_TO_CLIENT. headroom bytes before the message are left
 * free, and are not counted. */
uint8_t *pro_pack_message(const Fovea__Message *message, size_t headroom, size_t *out_count);

/* --- frames --- */

/* Collects bytes of a stream, and gives whole messages. */
struct pro_reader {
    size_t limit; /* longest frame accepted */
    size_t start; /* where the bytes held begin */
    size_t used;  /* bytes held */
    size_t size;  /* bytes allocated: as many as have come need, and at most limit + 4 + PRO_CHUNK */
    uint8_t *bytes;
};

void pro_reader_init(struct pro_reader *reader, size_t limit);
void pro_reader_finish(struct pro_reader *reader);

/* Add count bytes from a peer. False if memory is short, or if it would hold more than a frame and PRO_CHUNK
 * bytes. That does not happen to a caller who adds at most PRO_CHUNK bytes and then takes messages until
 * PRO_MORE. */
bool pro_reader_add(struct pro_reader *reader, const void *bytes, size_t count);

enum pro_result { PRO_MESSAGE, PRO_MORE, PRO_BROKEN };

/* Take the next message. PRO_MESSAGE: *out_message is a message, which the caller frees with
 * fovea__message__free_unpacked(m, NULL). PRO_MORE: no whole frame has come. PRO_BROKEN, with a line in
 * out_error: the peer must be dropped, since a frame has length 0 or is longer than the limit, or
 * pro_unpack_message() refuses its bytes. A length is checked as soon as its four bytes are there. */
enum pro_result pro_reader_take(struct pro_reader *reader, Fovea__Message **out_message,
                                char out_error[PRO_ERROR_SIZE]);

/* Write the length of a packed message into the PRO_PREFIX bytes before it in a frame. */
void pro_put_length(uint8_t out_prefix[PRO_PREFIX], size_t count);

/* Pack a message as a frame: as pro_pack_message(), with its length before it. */
uint8_t *pro_pack(const Fovea__Message *message, size_t headroom, size_t *out_count);

/* --- encodings --- */

/* Is it an encoding of tiles? */
bool pro_encodes(Fovea__Encoding encoding);

/* Encode a tile of size x size RGB floats, linear radiance; size is at most PRO_MAX_TILE. Returns malloc'ed
 * bytes, which the caller frees, and their count; NULL if memory is short, or if there is no such encoding
 * or size. NaN becomes 0; half floats are clamped to +-65504, RGB9E5 to 0 to 65408, JPEG to what a display
 * shows, 0 to 1. Any thread may call this. */
uint8_t *pro_encode(Fovea__Encoding encoding, const float *rgb, unsigned size, size_t *out_count);

/* Decode into size x size RGB floats, linear radiance. False, with out_rgb undefined, if the bytes are not
 * exactly such a tile of finite numbers, or memory is short. Whatever the bytes, it stays within its buffers
 * and allocates no more than a tile of that size needs. Any thread may call this. */
bool pro_decode(Fovea__Encoding encoding, const uint8_t *bytes, size_t count, unsigned size, float *out_rgb);

/* --- addresses --- */

/* Parse "unix:PATH", "tcp:HOST:PORT" or "http:HOST:PORT" (HOST may be [v6]), a bare path with a '/', or NULL
 * for the default:
 * $XDG_RUNTIME_DIR/fovead.sock, else /tmp/fovead-UID/fovead.sock, whose folder is made if it is missing.
 * False with a line in out_error if text is none of these, or if the folder of the default belongs to another
 * user or is writable by others. */
struct pro_address {
    bool is_unix;
    bool is_http;   /* WebSocket and a page, for browsers: pro_connect() refuses it */
    char path[108]; /* unix: fits sockaddr_un */
    char host[256]; /* tcp and http */
    uint16_t port;
};
bool pro_address_parse(const char *text, struct pro_address *out_address, char out_error[PRO_ERROR_SIZE]);
/* True for unix sockets and for 127.0.0.0/8, ::1 and "localhost". */
bool pro_address_is_local(const struct pro_address *address);
/* The address as text, in the form that pro_address_parse() takes. */
void pro_address_print(const struct pro_address *address, char *out_text, size_t size);

/* Set up a connected TCP socket of either side: small messages are sent at once, and the connection breaks
 * within about a minute if the peer has vanished or takes nothing. */
void pro_tcp_options(int fd);

/* Connect, and wait for that until deadline_ns (CLOCK_MONOTONIC), which look-ups of names may overstep.
 * wait_for_daemon: retry while nothing listens. Returns a non-blocking socket, which the caller closes; -1
 * and a line in out_error on failure. A Unix socket on which another user than this one or root listens is
 * refused. */
int pro_dial(const struct pro_address *address, uint64_t deadline_ns, bool wait_for_daemon,
             char out_error[PRO_ERROR_SIZE]);

/* --- client --- */

/* A connection, used by one thread. */
struct pro_client;

/* Connect, send hello, whose version is filled in, and wait for Welcome. All of that takes at most timeout_ms
 * (-1: no limit), not counting name look-ups. wait_for_daemon: retry while nothing listens. NULL and a line
 * in out_error on failure; if the daemon refused with a Done, the line is its text. Nothing is sent to a Unix
 * socket on which another user than this one or root listens. */
struct pro_client *pro_connect(const struct pro_address *address, const Fovea__Hello *hello, int timeout_ms,
                               bool wait_for_daemon, char out_error[PRO_ERROR_SIZE]);
void pro_disconnect(struct pro_client *client); /* accepts NULL */

const Fovea__Welcome *pro_welcome(const struct pro_client *client);
int pro_client_fd(const struct pro_client *client); /* for poll(); the client owns it */

/* Receive the next message, waiting at most timeout_ms (-1: no limit). PRO_MESSAGE: the caller frees the
 * message. PRO_MORE: none came in time. PRO_BROKEN, with a line in out_error: the daemon has gone, or sent
 * what it may not.
 *
 * A message is a Tile, Gaze, Stats, Done, Pong or Bye, and checked. A Tile has a place in the film, and its
 * pixels are in the picture already, unless its generation is over; the first Tile of a new generation has
 * emptied the picture. A Gaze has 3 finite numbers of direction, 0 or 3 of aim, and 0 or 4 of head; Stats and
 * Done have 0 or 3 of camera. Text has no control characters.
 *
 * Tiles are acknowledged before they are returned, or a few at a time when more messages have come: call this
 * again until PRO_MORE. */
enum pro_result pro_receive(struct pro_client *client, int timeout_ms, Fovea__Message **out_message,
                            char out_error[PRO_ERROR_SIZE]);

/* Send a message, and wait until the socket has taken it. False and a line in out_error if the connection is
 * broken, the message is longer than PRO_MAX_TO_DAEMON, or the daemon has taken nothing for ten seconds. */
bool pro_send(struct pro_client *client, const Fovea__Message *message, char out_error[PRO_ERROR_SIZE]);

/* The smallest recent round trip, and from it the daemon's clock minus ours, both in ns. Older round trips
 * count less, since clocks drift. False before the first Pong. pro_receive() sends a Ping about once a
 * second. */
bool pro_clock(const struct pro_client *client, uint64_t *out_round_trip_ns, int64_t *out_offset_ns);

/* --- picture --- */

/* The picture that a client has put together from its tiles: for every pixel the finest level that has come.
 * The client owns it; use it in the client's thread. It takes 6 bytes per pixel of the tiles that have come.
 */
struct pro_picture;
const struct pro_picture *pro_picture(const struct pro_client *client);

/* The share of the film (0 to 1) that has come, at any level. */
double pro_picture_coverage(const struct pro_picture *picture);

/* Fill out_rgb, height x width x RGB floats of the film's size (see Welcome), with linear radiance. The
 * pixels of coarse tiles are interpolated bilinearly, across neighbours of the same level and across the
 * seam. Where no tile has come, it is 0. */
void pro_picture_resolve(const struct pro_picture *picture, float *out_rgb);

/* --- viewers: tev and HDRView --- */

/* What is sent to a viewer that takes pictures by tev's protocol: packets, one after the other. A viewer
 * only reads. Each function returns a malloc'ed packet of *out_count bytes, which the caller frees; NULL if
 * memory is short, or if the packet would be 4 GiB or longer. Texts are UTF-8. */
enum { PRO_TEV_PORT = 14158 }; /* where viewers listen, on this machine */

struct pro_tev_image {
    const char *name; /* by which the viewer knows the picture */
    int width, height, channels;
    const char *const *channel; /* their names; R, G and B are shown as colour */
};

/* Open a picture, which is 0 everywhere, and show it. It takes the place of a picture of that name. */
uint8_t *pro_tev_create(const struct pro_tev_image *image, size_t *out_count);

/* A part of a picture: width x height pixels from (x, y) on, the channels of a pixel side by side. A viewer
 * ignores a part that is not wholly inside the picture. */
struct pro_tev_part {
    int x, y, width, height;
    const float *values;
};
uint8_t *pro_tev_update(const struct pro_tev_image *image, const struct pro_tev_part *part,
                        size_t *out_count);

/* Lines over a picture, in place of those that are there. Lines are 3 pixels of the screen wide. Their
 * points are pixels of the picture, from its top left corner on. */
enum pro_tev_pen {
    PRO_TEV_COLOUR = 4,   /* red, green, blue, alpha */
    PRO_TEV_STROKE = 5,   /* draw the path */
    PRO_TEV_BEGIN = 6,    /* a path */
    PRO_TEV_MOVE_TO = 10, /* x, y */
    PRO_TEV_LINE_TO = 11, /* x, y */
};
struct pro_tev_command {
    enum pro_tev_pen pen;
    float argument[4];
};
uint8_t *pro_tev_draw(const struct pro_tev_image *image, const struct pro_tev_command *command, int count,
                      size_t *out_count);

PROTOBUF_C__END_DECLS

#endif
