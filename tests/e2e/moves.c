/* A client that moves the camera faster than the daemon can follow: every move is answered, generations only
 * go up, the newest move wins, and in the end its generation is rendered. */
#include <math.h>
#include <stdio.h>

#include "protocol.h"

enum { MOVES = 30, PATIENCE_MS = 3600000 };

static Fovea__Message *next(struct pro_client *client, Fovea__Message__BodyCase kind)
{
    char error[PRO_ERROR_SIZE] = "nothing came";
    Fovea__Message *message;

    while (pro_receive(client, PATIENCE_MS, &message, error) == PRO_MESSAGE) {
        if (message->body_case == kind) return message;
        fovea__message__free_unpacked(message, NULL);
    }
    fprintf(stderr, "%s\n", error);
    return NULL;
}

static bool is_at(const float *camera, size_t count, float x)
{
    return count == 3 && fabsf(camera[0] - x) < 1e-3f && camera[1] == 0.5f && camera[2] == -0.5f;
}

int main(int argc, char **argv)
{
    Fovea__Hello hello = FOVEA__HELLO__INIT;
    Fovea__Message message = FOVEA__MESSAGE__INIT, *answer;
    Fovea__Move move = FOVEA__MOVE__INIT;
    struct pro_address address;
    struct pro_client *client;
    char error[PRO_ERROR_SIZE];
    float camera[3] = {-1, 0.5f, -0.5f};
    uint64_t generation = 0, first = 0;
    bool good = true;

    if (argc != 2 || !pro_address_parse(argv[1], &address, error)) return 2;
    hello.stats = true;
    client = pro_connect(&address, &hello, PATIENCE_MS, false, error);
    if (!client) return fprintf(stderr, "%s\n", error), 1;
    message.body_case = FOVEA__MESSAGE__BODY_MOVE;
    message.move = &move;
    move.n_camera = 3;
    move.camera = camera;
    /* First to a place, then in steps to the right. */
    for (int i = 0; i < MOVES && good; i++) {
        move.request = (uint32_t)i + 1;
        good = pro_send(client, &message, error);
        move.relative = true;
        camera[0] = 0.05f;
        camera[1] = camera[2] = 0;
    }
    for (int i = 0; i < MOVES && good; i++) {
        if (!(answer = next(client, FOVEA__MESSAGE__BODY_DONE))) return 1;
        good = answer->done->ok && answer->done->request == (uint32_t)i + 1 &&
               answer->done->generation >= generation &&
               is_at(answer->done->camera, answer->done->n_camera, -1 + 0.05f * (float)i);
        if (!good) fprintf(stderr, "move %d: %s\n", i + 1, answer->done->text);
        generation = answer->done->generation;
        if (!first) first = generation;
        fovea__message__free_unpacked(answer, NULL);
    }
    for (bool there = false; good && !there;) {
        if (!(answer = next(client, FOVEA__MESSAGE__BODY_STATS))) return 1;
        there = answer->stats->generation == generation;
        good = answer->stats->generation <= generation &&
               (!there || is_at(answer->stats->camera, answer->stats->n_camera, -1 + 0.05f * (MOVES - 1)));
        if (!good)
            fprintf(stderr, "the picture is of generation %llu\n",
                    (unsigned long long)answer->stats->generation);
        fovea__message__free_unpacked(answer, NULL);
    }
    pro_disconnect(client);
    printf("%d moves began %llu generations\n", MOVES, (unsigned long long)(generation - first + 1));
    return good ? 0 : 1;
}
