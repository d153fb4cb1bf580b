/* One client: what it says. What it is sent is in send.c. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session_internal.h"

/* Tiles under way unacknowledged, unless the client asks for another number; and the most it may ask for. */
enum { WINDOW = 64, MOST_WINDOW = 1024 };

/* A client has 5 s to say Hello, and to finish a frame that it began. Counted in calls of
 * dmn_session_check(), not by the clock: if the daemon runs late, what the client sent in time is taken
 * before the next call. */
enum { PATIENCE = 5 * DMN_CHECKS_A_SECOND };

struct dmn_session *dmn_session_create(const struct dmn_session_options *options)
{
    struct dmn_session *session = calloc(1, sizeof(*session));

    if (!session) return NULL;
    session->options = *options;
    session->common = options->common;
    snprintf(session->peer, sizeof(session->peer), "%s", options->peer);
    session->options.peer = session->peer;
    pro_reader_init(&session->reader, PRO_MAX_TO_DAEMON);
    session->common->clients++;
    return session;
}

void dmn_session_destroy(struct dmn_session *session)
{
    if (!session) return;
    if (session->common->view_owner == session->options.number) {
        session->common->view_owner = 0;
        dmn_gaze_view(session->common->gaze, NULL, 0, 0);
    }
    session->common->clients--;
    if (session->held) fovea__message__free_unpacked(session->held, NULL);
    pro_reader_finish(&session->reader);
    free(session->sent);
    free(session);
}

unsigned dmn_session_number(const struct dmn_session *session)
{
    return session->options.number;
}

const char *dmn_session_peer(const struct dmn_session *session)
{
    return session->peer;
}

bool dmn_session_greeted(const struct dmn_session *session)
{
    return session->greeted;
}

static bool fail(char out_error[PRO_ERROR_SIZE], const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static bool fail(char out_error[PRO_ERROR_SIZE], const char *format, ...)
{
    va_list args;

    va_start(args, format);
    vsnprintf(out_error, PRO_ERROR_SIZE, format, args);
    va_end(args);
    return false;
}

/* What the client calls itself joins its name in the log, as far as it is plain text. */
static void note_name(struct dmn_session *session, const char *name)
{
    size_t length = strlen(session->peer), room = sizeof(session->peer) - 1;

    if (*name && length + 2 < room) length += (size_t)sprintf(session->peer + length, ", ");
    for (; *name && length < room; name++)
        if (*name >= ' ' && *name <= '~') session->peer[length++] = *name;
    session->peer[length] = '\0';
}

/* What a client that is who it should be wants. */
static bool greet(struct dmn_session *session, const Fovea__Hello *hello, char out_error[PRO_ERROR_SIZE])
{
    switch (hello->tiles) {
    case FOVEA__ENCODING__ENCODING_NONE:
        break;
    case FOVEA__ENCODING__ENCODING_HALF_ZSTD:
    case FOVEA__ENCODING__ENCODING_JPEG:
        session->sent = calloc(session->common->pyramid.count, sizeof(*session->sent));
        if (!session->sent) return fail(out_error, "out of memory");
        break;
    default:
        return fail(out_error, "it wants tiles in an unknown encoding, %d", (int)hello->tiles);
    }
    session->encoding = hello->tiles;
    session->window = hello->window ? hello->window : WINDOW;
    if (session->window > MOST_WINDOW) session->window = MOST_WINDOW;
    session->wants_gaze = hello->gaze;
    session->wants_stats = session->stats_due = hello->stats;
    return session->greeted = session->welcome_due = true;
}

/* Its token is looked at now, or the Hello is held until it is. */
static bool take_hello(struct dmn_session *session, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    const Fovea__Hello *hello = message->hello;
    struct dmn_gate *gate = &session->common->gate;
    const char *token = session->options.token;
    uint64_t now_ns = dmn_now_ns();

    note_name(session, hello->client);
    if (hello->version != PRO_VERSION)
        return fail(out_error, "it speaks version %u of the protocol, not %d", hello->version, PRO_VERSION);
    if (!token) return greet(session, hello, out_error);
    if (!*hello->token) return fail(out_error, "it sent no token: set FOVEAD_TOKEN in its environment");
    session->turn_ns = dmn_gate_turn(gate, session->options.key, now_ns);
    if (!session->turn_ns)
        return fail(out_error, "too many wrong tokens came from its address: try again in some seconds");
    if (session->turn_ns > now_ns) {
        session->held = message;
        return true;
    }
    if (dmn_gate_knows(token, hello->token)) return greet(session, hello, out_error);
    dmn_gate_wrong(gate, session->options.key, now_ns);
    return fail(out_error, "its token is wrong");
}

/* The turn of a Hello that was held, and then of what came behind it. */
static bool take_held(struct dmn_session *session, char out_error[PRO_ERROR_SIZE])
{
    Fovea__Message *message = session->held;
    bool right = dmn_gate_knows(session->options.token, message->hello->token);
    bool good = right ? greet(session, message->hello, out_error) : fail(out_error, "its token is wrong");

    if (right) dmn_gate_right(&session->common->gate, session->options.key);
    session->held = NULL;
    fovea__message__free_unpacked(message, NULL);
    session->checks = 0;
    return good && dmn_session_take(session, NULL, 0, out_error);
}

static bool take_view(struct dmn_session *session, const Fovea__View *view, char out_error[PRO_ERROR_SIZE])
{
    float q[4], square = 0;

    if (view->n_orientation != 4) return fail(out_error, "a view without orientation");
    for (int i = 0; i < 4; i++) square += view->orientation[i] * view->orientation[i];
    if (!isfinite(square) || square < 1e-6f || !(view->fov_x > 0 && view->fov_x < (float)M_PI) ||
        !(view->fov_y > 0 && view->fov_y < (float)M_PI))
        return fail(out_error, "a view that is none");
    for (int i = 0; i < 4; i++) q[i] = view->orientation[i] / sqrtf(square);
    session->common->view_owner = session->options.number;
    dmn_gaze_view(session->common->gaze, q, view->fov_x, view->fov_y);
    return true;
}

static bool reply(struct dmn_session *session, struct dmn_reply reply, char out_error[PRO_ERROR_SIZE])
{
    if (session->replies + session->saves >= DMN_REPLIES)
        return fail(out_error, "it asks and does not listen");
    session->reply[(session->first_reply + session->replies++) % DMN_REPLIES] = reply;
    return true;
}

static struct dmn_reply done(uint32_t request, bool good, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static struct dmn_reply done(uint32_t request, bool good, const char *format, ...)
{
    struct dmn_reply reply = {.is_done = true, .request = request, .good = good};
    va_list args;

    va_start(args, format);
    vsnprintf(reply.text, sizeof(reply.text), format, args);
    va_end(args);
    return reply;
}

/* What waits for the disk is the saver's; its answer has a place among the replies from now on. */
static bool ask(struct dmn_session *session, struct dmn_save *job, char out_error[PRO_ERROR_SIZE])
{
    job->client = session->options.number;
    if (session->replies + session->saves >= DMN_REPLIES)
        return fail(out_error, "it asks and does not listen");
    if (!dmn_saver_ask(session->common->saver, job))
        return reply(session, done(job->request, false, "too many files are waiting to be written"),
                     out_error);
    session->saves++;
    return true;
}

/* A client may name a file only where it is this user. */
static bool take_path(struct dmn_session *session, struct dmn_save *job, const char *path, const char *ending)
{
    size_t length = strlen(path), end = strlen(ending);

    if (!session->options.may_save) {
        snprintf(job->text, sizeof(job->text), "files are written only for clients on a Unix socket");
        return false;
    }
    if (path[0] != '/' || length >= sizeof(job->path) || length < end ||
        strcmp(path + length - end, ending) != 0) {
        snprintf(job->text, sizeof(job->text), "an absolute path%s%s is needed",
                 *ending ? " that ends in " : "", ending);
        return false;
    }
    memcpy(job->path, path, length + 1);
    return true;
}

static bool take_save(struct dmn_session *session, const Fovea__Save *save, char out_error[PRO_ERROR_SIZE])
{
    struct dmn_save job = {.request = save->request, .what = DMN_SAVE_FILM};

    if (!take_path(session, &job, save->path, ".exr"))
        return reply(session, done(job.request, false, "%s", job.text), out_error);
    return ask(session, &job, out_error);
}

static bool take_record(struct dmn_session *session, const Fovea__Record *record,
                        char out_error[PRO_ERROR_SIZE])
{
    struct dmn_save job = {.request = record->request,
                           .what = record->on ? DMN_SAVE_GAZE : DMN_SAVE_GAZE_END,
                           .replace = record->replace};

    if (!take_path(session, &job, record->on ? record->path : "/", ""))
        return reply(session, done(job.request, false, "%s", job.text), out_error);
    return ask(session, &job, out_error);
}

static bool take_recentre(struct dmn_session *session, const Fovea__Recentre *recentre,
                          char out_error[PRO_ERROR_SIZE])
{
    struct dmn_save job = {
        .request = recentre->request, .what = DMN_SAVE_RECENTRE, .has_target = recentre->n_direction};
    double square = 0;

    if (recentre->n_direction != 0 && recentre->n_direction != 3)
        return fail(out_error, "a recentring without direction");
    for (size_t i = 0; i < recentre->n_direction; i++)
        square += (double)recentre->direction[i] * recentre->direction[i];
    if (recentre->n_direction && (!isfinite(square) || square < 1e-6))
        return fail(out_error, "a recentring to no direction");
    for (size_t i = 0; i < recentre->n_direction; i++)
        job.target[i] = (float)(recentre->direction[i] / sqrt(square));
    return ask(session, &job, out_error);
}

static bool take_move(struct dmn_session *session, const Fovea__Move *move, char out_error[PRO_ERROR_SIZE])
{
    struct dmn_reply answer;
    double eye[3] = {0};
    uint64_t generation;

    for (size_t i = 0; i < 3 && move->n_eye == 3; i++) eye[i] = (double)move->eye[i];
    if (move->n_eye != 3 || !dmn_eye_is_somewhere(eye)) return fail(out_error, "a move to nowhere");
    if (session->common->options->virtual_clock)
        return reply(session,
                     done(move->request, false,
                          "the eye stays: under the virtual clock a picture does not depend on clients"),
                     out_error);
    generation = dmn_painter_move(session->common->painter, eye, move->relative, eye);
    if (!generation)
        return reply(session,
                     done(move->request, false, "the eye stays within %d m of the origin", DMN_FARTHEST),
                     out_error);
    answer = done(move->request, true, "generation %llu, eye %.6g,%.6g,%.6g m",
                  (unsigned long long)generation, eye[0], eye[1], eye[2]);
    answer.generation = generation;
    for (int i = 0; i < 3; i++) answer.eye[i] = (float)eye[i];
    return reply(session, answer, out_error);
}

void dmn_session_saved(struct dmn_session *session, const struct dmn_save *save)
{
    char error[PRO_ERROR_SIZE];

    session->saves--; /* which makes the room that its answer needs */
    (void)reply(session, done(save->request, save->good, "%s", save->text), error);
}

static bool take_message(struct dmn_session *session, Fovea__Message *message, char out_error[PRO_ERROR_SIZE])
{
    switch (message->body_case) {
    case FOVEA__MESSAGE__BODY_HELLO:
        if (session->greeted) return fail(out_error, "it said hello twice");
        return take_hello(session, message, out_error);
    case FOVEA__MESSAGE__BODY_VIEW:
        return take_view(session, message->view, out_error);
    case FOVEA__MESSAGE__BODY_POINTER:
        if (message->pointer->n_direction != 3) return fail(out_error, "a pointer without direction");
        dmn_gaze_push(session->common->gaze, message->pointer->direction);
        return true;
    case FOVEA__MESSAGE__BODY_FREEZE:
        dmn_gaze_freeze(session->common->gaze, message->freeze->frozen);
        return true;
    case FOVEA__MESSAGE__BODY_ACKNOWLEDGE:
        if (message->acknowledge->serial > session->serial)
            return fail(out_error, "it acknowledges a tile that was not sent");
        if (message->acknowledge->serial > session->acknowledged)
            session->acknowledged = message->acknowledge->serial;
        return true;
    case FOVEA__MESSAGE__BODY_SAVE:
        return take_save(session, message->save, out_error);
    case FOVEA__MESSAGE__BODY_RECORD:
        return take_record(session, message->record, out_error);
    case FOVEA__MESSAGE__BODY_RECENTRE:
        return take_recentre(session, message->recentre, out_error);
    case FOVEA__MESSAGE__BODY_MOVE:
        return take_move(session, message->move, out_error);
    case FOVEA__MESSAGE__BODY_PING:
        return reply(session, (struct dmn_reply){.client_ns = message->ping->client_ns}, out_error);
    default:
        return fail(out_error, "it sent a message that clients do not send");
    }
}

bool dmn_session_take(struct dmn_session *session, const void *bytes, size_t count,
                      char out_error[PRO_ERROR_SIZE])
{
    bool good = pro_reader_add(&session->reader, bytes, count) ||
                fail(out_error, session->held ? "it did not wait for an answer" : "out of memory");

    while (good && !session->held) {
        Fovea__Message *message;
        enum pro_result result = pro_reader_take(&session->reader, &message, out_error);

        if (result == PRO_BROKEN) return false;
        if (result == PRO_MORE) break;
        good = session->greeted || message->body_case == FOVEA__MESSAGE__BODY_HELLO
                   ? take_message(session, message, out_error)
                   : fail(out_error, "it did not say hello first");
        if (message != session->held) fovea__message__free_unpacked(message, NULL);
        session->checks = 0;
    }
    if (!session->reader.used)
        session->partial = false;
    else if (!session->partial) {
        session->partial = true;
        session->checks = 0;
    }
    return good;
}

bool dmn_session_check(struct dmn_session *session, char out_error[PRO_ERROR_SIZE])
{
    if (session->held) return dmn_now_ns() < session->turn_ns || take_held(session, out_error);
    if (++session->checks < PATIENCE) return true;
    if (!session->greeted) return fail(out_error, "it did not say hello");
    if (session->partial) return fail(out_error, "it began a frame and did not end it");
    return true;
}
