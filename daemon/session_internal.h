/* The inside of a session, for session.c (what the client says) and send.c (what it is sent). */
#ifndef FOVEAD_DAEMON_SESSION_INTERNAL_H
#define FOVEAD_DAEMON_SESSION_INTERNAL_H

#include "next.h"
#include "session.h"

enum {
    DMN_REPLIES = 32, /* waiting to be sent; a client that lets more pile up is dropped */
    DMN_PLAN = 64,    /* tiles chosen at a time */
};

/* A Pong or a Done. */
struct dmn_reply {
    bool is_done, good;
    uint32_t request;
    uint64_t client_ns;
    uint64_t generation; /* of a move; 0: it is none, and there is no eye */
    float eye[3];
    char text[DMN_TEXT_SIZE];
};

struct dmn_session {
    struct dmn_session_options options;
    struct dmn_common *common;
    char peer[96];
    struct pro_reader reader;
    unsigned checks; /* since the client has been waited for, for Hello or for the rest of a frame */
    bool greeted, partial;
    Fovea__Message *held; /* its Hello, as long as its token is not looked at; NULL: none is held */
    uint64_t turn_ns;     /* when it is */
    bool ending, bye_due; /* nothing but Bye is sent any more; it has not been */

    Fovea__Encoding encoding;
    uint32_t window;
    bool wants_gaze, wants_stats, welcome_due, stats_due;
    uint64_t gaze_cursor;
    struct dmn_reply reply[DMN_REPLIES];
    unsigned first_reply, replies;
    unsigned saves; /* asked of the saver and not yet answered: each has a place among the replies */

    uint64_t serial, acknowledged;
    uint64_t gaze_sequence; /* the newest of the tiles sent */
    struct dmn_tile *sent;  /* what each tile was when it was sent; NULL if no tiles are wanted */
    uint64_t generation;    /* that they were of */
    struct dmn_place plan[DMN_PLAN];
    size_t planned, next;
    uint64_t plan_version; /* of the pyramid that the plan was made from */
};

#endif
