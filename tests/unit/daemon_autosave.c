/* Saves at intervals: when they are due, and what people are told. The jobs, the painter and the clock are
 * false ones. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "autosave.h"
#include "job_kinds.h"
#include "options.h"
#include "paint.h"

static const uint64_t S = 1000000000;

static uint64_t now_ns, paths;
static bool has_room;
static int asked;
static struct dmn_job job;

uint64_t __wrap_dmn_now_ns(void);
uint64_t __wrap_dmn_now_ns(void)
{
    return now_ns;
}

bool dmn_jobs_ask(struct dmn_jobs *jobs, const struct dmn_job *new_job)
{
    (void)jobs;
    asked++;
    job = *new_job;
    return has_room;
}

void dmn_painter_work(struct dmn_painter *painter, struct dmn_work *out_work)
{
    (void)painter;
    *out_work = (struct dmn_work){.paths = paths};
}

const struct dmn_job_kind dmn_job_save;

static const struct dmn_options options = {.save = "a.png", .save_every = 10, .exposure = {.stops = 1.5}};
static const struct dmn_handles handles = {.options = &options};

static int begin(void **state)
{
    (void)state;
    now_ns = 123456789 * S;
    paths = 1;
    has_room = true;
    asked = 0;
    return 0;
}

/* Four ticks a second until so many seconds have passed; returns how many saves are asked for in them. */
static int pass(struct dmn_autosave *autosave, int seconds)
{
    const int before = asked;

    for (int i = 0; i < 4 * seconds; i++) {
        dmn_autosave_tick(autosave, &handles);
        now_ns += S / 4;
    }
    return asked - before;
}

static void done(struct dmn_autosave *autosave, bool good)
{
    job.good = good;
    snprintf(job.text, sizeof(job.text), good ? "wrote it" : "no room");
    dmn_autosave_done(autosave, &job);
}

static void each_interval_has_one(void **state)
{
    struct dmn_autosave autosave = {0};

    (void)state;
    assert_int_equal(pass(&autosave, 10), 0);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(pass(&autosave, 1), 1);
        assert_true(job.kind == &dmn_job_save && job.client == 0 && job.exposure.stops == 1.5);
        assert_string_equal(job.path, "a.png");
        done(&autosave, true);
        assert_int_equal(pass(&autosave, 9), 0);
    }
    /* The machine has slept: there is one save, and then the next in its time. */
    now_ns += 1000 * S + 5 * S;
    assert_int_equal(pass(&autosave, 1), 1);
    done(&autosave, true);
    assert_int_equal(pass(&autosave, 4), 0);
    assert_int_equal(pass(&autosave, 1), 1);
}

static void long_saves_do_not_pile_up(void **state)
{
    struct dmn_autosave autosave = {0};

    (void)state;
    pass(&autosave, 10);
    assert_int_equal(pass(&autosave, 35), 1);
    done(&autosave, true); /* after 35 s: the next is due after 40 */
    assert_int_equal(pass(&autosave, 5), 0);
    assert_int_equal(pass(&autosave, 10), 1);
}

static void empty_pictures_and_full_queues_wait(void **state)
{
    struct dmn_autosave autosave = {0};

    (void)state;
    paths = 0;
    assert_int_equal(pass(&autosave, 25), 0);
    paths = 1;
    has_room = false;
    assert_int_equal(pass(&autosave, 10), 1);
    has_room = true;
    assert_int_equal(pass(&autosave, 10), 1);
}

static void faults_are_told_once(void **state)
{
    static const struct {
        bool good;
        const char *says;
    } SAVES[] = {
        {true, ""}, {false, "no room"}, {false, ""},          {false, ""}, {true, "saved again: wrote it"},
        {true, ""}, {false, "no room"}, {true, "saved again"}};
    struct dmn_autosave autosave = {0};

    (void)state;
    for (size_t i = 0; i < sizeof(SAVES) / sizeof(*SAVES); i++) {
        FILE *file = tmpfile();
        char said[500];
        int kept = dup(STDERR_FILENO);

        dup2(fileno(file), STDERR_FILENO);
        done(&autosave, SAVES[i].good);
        fflush(stderr);
        dup2(kept, STDERR_FILENO);
        close(kept);
        rewind(file);
        said[fread(said, 1, sizeof(said) - 1, file)] = '\0';
        fclose(file);
        if (*SAVES[i].says) assert_non_null(strstr(said, SAVES[i].says));
        assert_int_equal(*SAVES[i].says != '\0', *said != '\0');
        assert_true(!*said || strchr(said, '\n') == said + strlen(said) - 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(each_interval_has_one, begin),
        cmocka_unit_test_setup(long_saves_do_not_pile_up, begin),
        cmocka_unit_test_setup(empty_pictures_and_full_queues_wait, begin),
        cmocka_unit_test_setup(faults_are_told_once, begin),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
