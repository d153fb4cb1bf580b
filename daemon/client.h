/* client: what the daemon knows of one client, for the files that serve it: hello.c, requests.c, send.c,
 * tiles.c, and session.c on top of them. All clients belong to the loop's thread. */
#ifndef FOVEAD_DAEMON_CLIENT_H
#define FOVEAD_DAEMON_CLIENT_H

#include "encode.h"
#include "gate.h"
#include "handles.h"
#include "jobs.h"
#include "next.h"
#include "picture.h"
#include "protocol.h"
#include "steering.h"

enum {
    DMN_ANSWERS = 32, /* waiting to be sent; a client that lets more pile up is dropped */
    DMN_PLAN = 64,    /* tiles chosen at a time */
};

/* What all clients share. */
struct dmn_clients {
    const struct dmn_handles *handles;
    const struct dmn_picture *picture;
    struct dmn_gate gate;
    struct dmn_encoder encoder;
    unsigned count;
    struct dmn_steering steering; /* not under the virtual clock */
};

struct dmn_client_options {
    struct dmn_clients *clients;
    unsigned number;   /* of the client, from 1 */
    const char *peer;  /* who it is, for people; copied */
    const char *token; /* that Hello must carry, or NULL */
    uint64_t key;      /* of its address, for the gate */
    bool may_save;     /* files are written for it */
    size_t headroom;   /* bytes left free before every message for it */
};

/* A Pong or a Done. */
struct dmn_answer {
    bool is_done, good;
    uint32_t request;
    uint64_t client_ns;
    uint64_t generation; /* that a Move begins; 0: the answer is to another request, and has no camera */
    float camera[3];     /* its position, m */
    char text[DMN_TEXT_SIZE];
};

struct dmn_client {
    struct dmn_client_options options;
    struct dmn_clients *clients;
    const struct dmn_handles *handles;
    const struct dmn_picture *picture;
    char peer[96];
    unsigned checks;      /* checks since the daemon began to wait for Hello, or for the rest of a message */
    bool greeted;         /* it has said Hello */
    bool partial;         /* a message had begun and not ended at the last check */
    Fovea__Message *held; /* its Hello, until the token in it is checked; NULL: none is held */
    uint64_t turn_ns;     /* when the token is checked */
    bool ending, bye_due; /* only Bye is still sent; it has not been sent yet */

    Fovea__Encoding encoding;
    uint32_t window; /* tiles that may be under way unacknowledged */
    int finest;      /* level that the client can hold */
    bool wants_gaze, wants_stats, wants_viewing, welcome_due, stats_due;
    struct dmn_shown shown;
    unsigned told; /* of steering.changes, plus 1; 0: nothing was told */
    uint64_t gaze_cursor;
    struct dmn_answer answer[DMN_ANSWERS];
    unsigned first_answer, answers;
    unsigned jobs; /* asked for and not done; a place among the answers is kept for each */

    uint64_t serial, acknowledged; /* of tiles */
    uint64_t gaze_sequence;        /* the newest of the tiles sent */
    struct dmn_tile *sent;         /* what each tile was when it was sent; NULL if no tiles are wanted */
    uint64_t generation;           /* of the tiles sent */
    struct dmn_place plan[DMN_PLAN];
    size_t planned, next;
    uint64_t plan_version; /* of the pyramid that the plan was made from */
};

/* Write a line on why the client must be dropped; returns false. */
bool dmn_client_fail(char out_error[PRO_ERROR_SIZE], const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Queue an answer. False with a line in out_error if the client lets too many pile up. */
bool dmn_client_answer(struct dmn_client *client, const struct dmn_answer *answer,
                       char out_error[PRO_ERROR_SIZE]);
/* Queue a Done with that text. */
bool dmn_client_done(struct dmn_client *client, uint32_t request, bool good, const char *text,
                     char out_error[PRO_ERROR_SIZE]);
/* Ask for a job, and keep a place among the answers for its Done. */
bool dmn_client_ask(struct dmn_client *client, struct dmn_job *job, char out_error[PRO_ERROR_SIZE]);

/* The client shows a view, or with NULL none any more: who steers by it? asks as for dmn_steering_show(). */
void dmn_client_show(struct dmn_client *client, const struct trk_view *view_or_null, bool headset, bool asks);

/* Pack a message whose body is content. malloc'ed, with the client's headroom before it; the caller frees.
 * NULL if memory is short. */
uint8_t *dmn_client_pack(const struct dmn_client *client, Fovea__Message__BodyCase body, void *content,
                         size_t *out_count);

#endif
