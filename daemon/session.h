/* session: one client, from Hello to the end. It takes the bytes that came and gives the frames that should
 * go; what carries them (a socket today) is its owner's matter. Nothing waits in it encoded: a tile is read
 * and encoded at the moment the client can take it, so the newest always wins and a slow client is just sent
 * less.
 *
 * All sessions belong to the loop's thread. */
#ifndef FOVEAD_DAEMON_SESSION_H
#define FOVEAD_DAEMON_SESSION_H

#include "gate.h"
#include "gaze.h"
#include "paint.h"
#include "pyramid.h"
#include "saver.h"

struct dmn_edits;

/* What clients are told of the scene. */
struct dmn_scene_words {
    char line[1024];
    char refused[RND_ERROR_SIZE]; /* why the last edit was not taken; "": it was */
};

/* What all sessions share. */
struct dmn_common {
    struct rnd_render *render;
    struct dmn_gaze *gaze;
    struct dmn_painter *painter;
    struct dmn_saver *saver;
    const struct dmn_options *options;
    struct dmn_edits *edits; /* NULL: the scene's files are not watched */
    struct dmn_scene_words words;

    struct dmn_pyramid pyramid;
    uint64_t generation;                  /* of what the pyramid tells */
    uint64_t version;                     /* of the pyramid: counts its updates */
    uint32_t visited, converged, settled; /* tiles of level 0 */
    float direction[3];                   /* that samples are aimed at */
    uint64_t gaze_sequence;               /* of the newest gaze that has paths in the tile where it looks */

    struct dmn_gate gate;
    unsigned clients;
    unsigned view_owner; /* number of the client whose View rules; 0 if none does */
};

struct dmn_session;

struct dmn_session_options {
    struct dmn_common *common;
    unsigned number;   /* of the client, from 1 */
    const char *peer;  /* copied */
    const char *token; /* that Hello must carry, or NULL */
    uint64_t key;      /* of its address, for the gate */
    bool may_save;     /* the client is on this machine and this user's */
    size_t headroom;   /* bytes free before every frame */
};

struct dmn_session *dmn_session_create(const struct dmn_session_options *options);
void dmn_session_destroy(struct dmn_session *session); /* accepts NULL */
unsigned dmn_session_number(const struct dmn_session *session);
const char *dmn_session_peer(const struct dmn_session *session);
/* Has it said Hello? */
bool dmn_session_greeted(const struct dmn_session *session);

/* Bytes from the client. False with a line in out_error if it must be dropped. */
bool dmn_session_take(struct dmn_session *session, const void *bytes, size_t count,
                      char out_error[PRO_ERROR_SIZE]);
/* Call it DMN_CHECKS_A_SECOND times per second, each time after the client's bytes were taken. False with a
 * line in out_error if the client is overdue with its Hello or the rest of a frame. */
enum { DMN_CHECKS_A_SECOND = 4 };
bool dmn_session_check(struct dmn_session *session, char out_error[PRO_ERROR_SIZE]);

/* Is there something to send? */
bool dmn_session_wants(struct dmn_session *session);
/* The next frame, malloc'ed with the headroom before it (the caller frees); NULL if there is nothing, or no
 * memory. */
uint8_t *dmn_session_frame(struct dmn_session *session, size_t *out_count);

/* Send nothing more but Bye. */
void dmn_session_end(struct dmn_session *session);

/* A last frame that tells a client why it is dropped, as dmn_session_frame(). */
uint8_t *dmn_farewell(const char *why, size_t headroom, size_t *out_count);

/* Statistics are due. */
void dmn_session_stats(struct dmn_session *session);
/* What this client asked the saver for is done, or is not. */
void dmn_session_saved(struct dmn_session *session, const struct dmn_save *save);

#endif
