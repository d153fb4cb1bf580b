/* The model of the synthetic observer, and its constants. */
#include "source/observer.h"

#include <cglm/cglm.h>
#include <math.h>
#include <string.h>

/* The lengths of fixations are lognormal. Their mean is in the middle of the usual 250 to 300 ms of scene
 * viewing. */
static const double fixation_mean_s = 0.275, fixation_sigma = 0.4;

/* Main sequence with the defaults of Dai et al. 2016: Vp = eta (1 - exp(-A / c)). */
static const double saccade_eta = 600, saccade_c = 6;
/* The closed form never quite starts or ends. 25 ms before and after, it is within 0.02 degrees of its ends.
 */
static const double saccade_tail_s = 0.025;
static const double onset_deg_s = 30;

/* Saccade amplitudes are exponential, with a mean of 5 to 8 degrees in free viewing, and rarely exceed 30. */
static const double amplitude_mean_deg = 6.5, amplitude_max_deg = 30;
/* Gaze in panoramas stays near the equator (Sitzmann et al. 2018, "Saliency in VR") and explores along it:
 * the directions of saccades spread around the horizontal, several saccades go the same way, and targets far
 * up or down are less likely. */
static const double bearing_sigma_deg = 35, turn_probability = 0.15, elevation_sigma_deg = 25;
static const int saccade_tries = 16;

/* The eye turns at most about 50 degrees in its socket (Guitton and Volle 1987). When gaze goes more than 20
 * degrees away from where the head is going, the head follows most of the way. */
static const double oculomotor_range_deg = 50, head_follows_deg = 20, head_share = 0.8;
/* A time constant of 1/8 s: a head movement of 40 degrees peaks at 120 deg/s and takes half a second. */
static const double head_rate = 8;
/* The head turns about the neck: the eyes are 0.075 m above and 0.080 m in front of it (Google Cardboard's
 * neck model). */
static const float neck_up_m = 0.075f, neck_forward_m = 0.080f;
static const float half_ipd_m = 0.0315f; /* Dodgson 2004: mean 63 mm */

/* Drift is a random walk of 30 square arc minutes per second. Microsaccades of 14 to 38 arc minutes, one or
 * two per second, bring gaze back near the target. */
static const double drift_arcmin2_per_s = 30, microsaccade_hz = 1.5, microsaccade_deg = 0.3;

/* The tracker adds white noise of 0.2 deg rms from sample to sample to the combined gaze (twice the standard
 * deviation of each axis), and a calibration bias of 0.7 deg rms that wanders within 20 s. */
static const double noise_s2s_deg = 0.2, bias_rms_deg = 0.7, bias_time_s = 20;
/* How many steps per unit the reported numbers have. The steps of directions, 0.0006 degrees, are too fine to
 * matter. */
static const double unit_steps = 1e5, metre_steps = 1e4, scalar_steps = 100;

/* How often something hides the eye, and for how long: one spell per period_s on average, at least pause_s
 * apart, of min_s to max_s. */
struct habit {
    double period_s, pause_s, min_s, max_s;
};

/* Blinks: 15 per minute, of 100 to 400 ms, at least a second apart. The lid goes down in the first third and
 * up in the last half. The tracker sees the pupil while the eye is at least half open. */
static const struct habit blinks = {.period_s = 4, .pause_s = 1, .min_s = 0.1, .max_s = 0.4};
static const double blink_down = 0.3, blink_up = 0.55, hidden_openness = 0.5;

/* Drop-outs: about six times per minute the tracker loses both eyes for 1 to 6 samples. */
static const struct habit dropouts = {.period_s = 10, .min_s = 0.005, .max_s = 0.05};

static const double pupil_mean_mm = 3.5, pupil_rms_mm = 0.3, pupil_time_s = 5;

static const uint32_t lid_bits = TRK_HEAD | TRK_LEFT_OPENNESS | TRK_RIGHT_OPENNESS;
static const uint32_t all_bits = TRK_DIRECTION | TRK_ORIGIN | TRK_HEAD | TRK_LEFT_DIRECTION |
                                 TRK_LEFT_ORIGIN | TRK_LEFT_OPENNESS | TRK_LEFT_PUPIL | TRK_RIGHT_DIRECTION |
                                 TRK_RIGHT_ORIGIN | TRK_RIGHT_OPENNESS | TRK_RIGHT_PUPIL;

/* --- chance --- */

/* A random number in (0, 1). SplitMix64 (Steele, Lea and Flood 2014): every seed is good, even next to
 * another one. */
static double uniform(struct trk_observer *o)
{
    uint64_t z = o->random += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    z ^= z >> 31;
    return ((double)(z >> 12) + 0.5) * 0x1p-52;
}

/* Box and Muller 1958. */
static double normal(struct trk_observer *o)
{
    double radius = sqrt(-2 * log(uniform(o)));
    return radius * cos(2 * M_PI * uniform(o));
}

static double exponential(struct trk_observer *o, double mean)
{
    return -mean * log(uniform(o));
}

static double between(struct trk_observer *o, double low, double high)
{
    return low + (high - low) * uniform(o);
}

/* One sample's step of an Ornstein-Uhlenbeck process around zero with this rms and time constant. */
static double wander(struct trk_observer *o, double value, double rms, double time_s)
{
    double keep = exp(-1 / (time_s * o->rate_hz));
    return value * keep + rms * sqrt(1 - keep * keep) * normal(o);
}

/* --- directions --- */

/* The right and the up direction of someone who looks along a direction. */
static void tangents(vec3 direction, vec3 out_right, vec3 out_up)
{
    glm_vec3_cross(direction, GLM_YUP, out_right);
    if (glm_vec3_norm(out_right) < 1e-3f) glm_vec3_copy(GLM_XUP, out_right);
    glm_vec3_normalize(out_right);
    glm_vec3_cross(out_right, direction, out_up);
}

/* Turn a direction by small angles to the right and up. */
static void displace(vec3 direction, const double deg[2], vec3 out)
{
    vec3 right, up;
    tangents(direction, right, up);
    glm_vec3_copy(direction, out);
    glm_vec3_muladds(right, (float)tan(deg[0] * M_PI / 180), out);
    glm_vec3_muladds(up, (float)tan(deg[1] * M_PI / 180), out);
    glm_vec3_normalize(out);
}

static void along_arc(vec3 from, vec3 tangent, double deg, vec3 out)
{
    glm_vec3_scale(from, (float)cos(deg * M_PI / 180), out);
    glm_vec3_muladds(tangent, (float)sin(deg * M_PI / 180), out);
    glm_vec3_normalize(out);
}

static double elevation_deg(vec3 direction)
{
    return asin(glm_clamp(direction[1], -1, 1)) * 180 / M_PI;
}

static void head_pose(const double deg[2], versor out)
{
    versor yaw, pitch;
    glm_quatv(yaw, (float)(deg[0] * M_PI / 180), GLM_YUP);
    glm_quatv(pitch, (float)(deg[1] * M_PI / 180), GLM_XUP);
    glm_quat_mul(yaw, pitch, out);
}

/* --- gaze --- */

/* The position of a point that smoothly starts to move with velocity 1 at t = 0 (Dai et al. 2016, eq. 5). */
static double smooth_ramp(double t)
{
    return (t >= 0 ? t : 0) + 0.25 * exp(-2 * fabs(t));
}

double trk_saccade_deg(double amplitude_deg, double t_s)
{
    double t = saccade_eta * (t_s - saccade_tail_s) / saccade_c;
    return saccade_c * (smooth_ramp(t) - smooth_ramp(t - amplitude_deg / saccade_c));
}

double trk_saccade_s(double amplitude_deg)
{
    return amplitude_deg / saccade_eta + 2 * saccade_tail_s;
}

/* When the eye first reaches 30 deg/s, the usual threshold (Tobii XR Ocumen), after the slow start of the
 * closed form. Found by bisection to a microsecond, between the start and the middle, where the eye is
 * fastest. */
static double saccade_onset_s(double amplitude_deg)
{
    double low = 0, high = 0.5 * trk_saccade_s(amplitude_deg);
    while (high - low > 1e-6) {
        double t = 0.5 * (low + high), step = 1e-6;
        double speed = (trk_saccade_deg(amplitude_deg, t + step) - trk_saccade_deg(amplitude_deg, t)) / step;
        if (speed < onset_deg_s)
            low = t;
        else
            high = t;
    }
    return high;
}

static void gaze_at(const struct trk_observer *o, double t_s, vec3 out)
{
    vec3 fixation, tangent; /* copies, because cglm takes no const */
    memcpy(fixation, o->fixation, sizeof fixation);
    memcpy(tangent, o->tangent, sizeof tangent);
    if (o->is_saccade)
        along_arc(fixation, tangent, trk_saccade_deg(o->amplitude_deg, t_s - o->phase_start_s), out);
    else
        displace(fixation, o->offset_deg, out);
}

static void begin_fixation(struct trk_observer *o)
{
    double mu = log(fixation_mean_s) - 0.5 * fixation_sigma * fixation_sigma;
    if (o->is_saccade) along_arc(o->fixation, o->tangent, o->amplitude_deg, o->fixation);
    o->is_saccade = false;
    o->offset_deg[0] = o->offset_deg[1] = 0;
    o->phase_start_s = o->phase_end_s;
    o->phase_end_s += exp(mu + fixation_sigma * normal(o));
}

/* If a target is far from where the head is going, send the head most of the way to it. */
static void send_head(struct trk_observer *o, vec3 target)
{
    double yaw = remainder(atan2(-target[0], -target[2]) * 180 / M_PI - o->head_target_deg[0], 360);
    double pitch = elevation_deg(target) - o->head_target_deg[1];
    if (hypot(yaw, pitch) <= head_follows_deg) return;
    o->head_target_deg[0] += head_share * yaw;
    o->head_target_deg[1] += head_share * pitch;
}

/* Draw targets until one is accepted. A target near the horizon is almost always accepted, one that the eye
 * cannot reach never. If none is accepted, take the most likely one. If none is in reach, gaze stays where it
 * is until the head has caught up. */
static void begin_saccade(struct trk_observer *o)
{
    versor head;
    vec3 from, right, up, forward = {0, 0, -1};
    gaze_at(o, o->phase_end_s, from);
    tangents(from, right, up);
    head_pose(o->head_deg, head);
    glm_quat_rotatev(head, forward, forward);
    if (uniform(o) < turn_probability) o->sweep = -o->sweep;

    double best = 0;
    o->amplitude_deg = 0;
    glm_vec3_copy(right, o->tangent);
    for (int i = 0; i < saccade_tries; i++) {
        double amplitude = fmin(exponential(o, amplitude_mean_deg), amplitude_max_deg);
        double bearing = bearing_sigma_deg * normal(o) * M_PI / 180;
        vec3 tangent, target;
        glm_vec3_scale(right, (float)(o->sweep * cos(bearing)), tangent);
        glm_vec3_muladds(up, (float)sin(bearing), tangent);
        along_arc(from, tangent, amplitude, target);
        double elevation = elevation_deg(target) / elevation_sigma_deg;
        bool in_reach = glm_vec3_angle(forward, target) * 180 / M_PI <= oculomotor_range_deg;
        double weight = in_reach ? exp(-0.5 * elevation * elevation) : 0;
        bool taken = uniform(o) < weight;
        if (taken || weight > best) {
            best = weight;
            o->amplitude_deg = amplitude;
            glm_vec3_copy(tangent, o->tangent);
        }
        if (taken) break;
    }
    vec3 target;
    along_arc(from, o->tangent, o->amplitude_deg, target);
    send_head(o, target);
    glm_vec3_copy(from, o->fixation);
    o->is_saccade = true;
    o->saccade_number++;
    o->phase_start_s = o->phase_end_s;
    o->phase_end_s += trk_saccade_s(o->amplitude_deg);
}

static void drift(struct trk_observer *o)
{
    double step_deg = sqrt(2 * drift_arcmin2_per_s / o->rate_hz) / 60;
    bool back = uniform(o) < microsaccade_hz / o->rate_hz;
    for (int i = 0; i < 2; i++)
        o->offset_deg[i] =
            back ? 0.5 * microsaccade_deg * normal(o) : o->offset_deg[i] + step_deg * normal(o);
}

/* One sample's step of the critically damped approach to the target; exact for any step. */
static void turn_head(struct trk_observer *o)
{
    double dt = 1.0 / o->rate_hz, decay = exp(-head_rate * dt);
    for (int i = 0; i < 2; i++) {
        double error = o->head_deg[i] - o->head_target_deg[i];
        double slope = o->head_speed[i] + head_rate * error;
        o->head_deg[i] = o->head_target_deg[i] + (error + slope * dt) * decay;
        o->head_speed[i] = (o->head_speed[i] - head_rate * slope * dt) * decay;
    }
}

/* --- what the tracker measures --- */

static double openness_at(const struct trk_observer *o, double t_s)
{
    double u = (t_s - o->blink.start_s) / o->blink.length_s;
    if (u <= 0 || u >= 1) return 1;
    if (u < blink_down) return 1 - u / blink_down;
    return u < blink_up ? 0 : (u - blink_up) / (1 - blink_up);
}

/* When a spell is over, draw when the next one starts and how long it lasts. */
static void renew(struct trk_observer *o, double t_s, const struct habit *habit, struct trk_spell *spell)
{
    if (t_s < spell->start_s + spell->length_s) return;
    spell->start_s += habit->pause_s + exponential(o, habit->period_s - habit->pause_s);
    spell->length_s = between(o, habit->min_s, habit->max_s);
}

/* Round to whole steps, of which there are `steps` per unit. Adding zero turns -0 into 0. */
static float round_to(double value, double steps)
{
    return (float)(rint(value * steps) / steps + 0.0);
}

static void round_vector(vec3 v, double steps, float out[3])
{
    for (int i = 0; i < 3; i++) out[i] = round_to(v[i], steps);
}

/* The eyes look in parallel, because a panorama is far away. Each eye has its own noise, so their mean has
 * less. */
static void measure_gaze(struct trk_observer *o, vec3 gaze, double openness, struct trk_sample *sample)
{
    double eye_noise_deg = 0.5 * M_SQRT2 * o->noise_s2s_deg;
    vec3 combined = GLM_VEC3_ZERO_INIT;
    for (int i = 0; i < 2; i++) {
        struct trk_eye *eye = &sample->eye[i];
        vec3 direction;
        displace(gaze,
                 (double[2]){o->bias_deg[0] + eye_noise_deg * normal(o),
                             o->bias_deg[1] + eye_noise_deg * normal(o)},
                 direction);
        glm_vec3_add(combined, direction, combined);
        round_vector(direction, unit_steps, eye->direction);
        eye->origin[0] = i == 0 ? -half_ipd_m : half_ipd_m;
        eye->pupil_mm = round_to(o->pupil_mm, scalar_steps);
        eye->openness = round_to(openness, scalar_steps);
    }
    glm_vec3_normalize(combined);
    round_vector(combined, unit_steps, sample->direction);
}

static void measure_head(versor head, struct trk_sample *sample)
{
    vec3 neck_to_eyes = {0, neck_up_m, -neck_forward_m}, eyes;
    glm_quat_rotatev(head, neck_to_eyes, eyes);
    glm_vec3_sub(eyes, neck_to_eyes, eyes); /* 0 when the head looks straight ahead */
    round_vector(eyes, metre_steps, sample->head);
    for (int i = 0; i < 4; i++) sample->head[3 + i] = round_to(head[i], unit_steps);
}

void trk_observer_init(struct trk_observer *observer, uint64_t seed)
{
    trk_observer_init_with(observer, seed, TRK_OBSERVER_HZ, noise_s2s_deg, bias_rms_deg);
}

void trk_observer_init_with(struct trk_observer *observer, uint64_t seed, uint64_t rate_hz, double s2s_deg,
                            double bias_deg)
{
    *observer = (struct trk_observer){.random = seed,
                                      .rate_hz = rate_hz,
                                      .noise_s2s_deg = s2s_deg,
                                      .bias_rms_deg = bias_deg,
                                      .fixation = {0, 0, -1}};
    observer->sweep = uniform(observer) < 0.5 ? -1 : 1;
    for (int i = 0; i < 2; i++) observer->bias_deg[i] = bias_deg * M_SQRT1_2 * normal(observer);
    observer->pupil_mm = pupil_mean_mm;
    begin_fixation(observer);
}

/* Is the eye hidden at this time? The openness is 1 during a drop-out. */
static bool is_hidden(const struct trk_observer *o, double t_s, double *out_openness)
{
    *out_openness = 1;
    if (t_s >= o->dropout.start_s && t_s < o->dropout.start_s + o->dropout.length_s) return true;
    *out_openness = openness_at(o, t_s);
    return *out_openness < hidden_openness;
}

void trk_observer_truth(const struct trk_observer *o, struct trk_truth *out_truth)
{
    double t_s = (double)(o->tick - 1) / (double)o->rate_hz, openness;
    vec3 gaze;
    gaze_at(o, t_s, gaze);
    *out_truth = (struct trk_truth){.is_saccade = o->is_saccade && o->amplitude_deg > 0,
                                    .amplitude_deg = o->is_saccade ? o->amplitude_deg : 0,
                                    .is_hidden = is_hidden(o, t_s, &openness)};
    out_truth->is_blink = out_truth->is_hidden && openness < 1;
    memcpy(out_truth->direction, gaze, sizeof out_truth->direction);
    if (!out_truth->is_saccade) return;
    out_truth->saccade_number = o->saccade_number;
    out_truth->onset_s = o->phase_start_s + saccade_onset_s(o->amplitude_deg);
    out_truth->end_s = o->phase_start_s + o->phase_end_s - out_truth->onset_s;
    gaze_at(o, o->phase_end_s, gaze);
    memcpy(out_truth->landing, gaze, sizeof out_truth->landing);
}

void trk_observer_next(struct trk_observer *o, struct trk_sample *out_sample)
{
    uint64_t tick = o->tick++;
    double t_s = (double)tick / o->rate_hz;
    while (o->phase_end_s <= t_s) {
        if (o->is_saccade)
            begin_fixation(o);
        else
            begin_saccade(o);
    }
    if (!o->is_saccade) drift(o);
    if (tick > 0) turn_head(o);
    renew(o, t_s, &blinks, &o->blink);
    renew(o, t_s, &dropouts, &o->dropout);
    for (int i = 0; i < 2; i++)
        o->bias_deg[i] = wander(o, o->bias_deg[i], o->bias_rms_deg * M_SQRT1_2, bias_time_s);
    o->pupil_mm = pupil_mean_mm + wander(o, o->pupil_mm - pupil_mean_mm, pupil_rms_mm, pupil_time_s);

    *out_sample = (struct trk_sample){
        .sequence = tick + 1,
        .device_ns = tick / o->rate_hz * 1000000000 + tick % o->rate_hz * 1000000000 / o->rate_hz,
        .valid = TRK_HEAD,
    };
    out_sample->arrival_ns = out_sample->device_ns;

    vec3 gaze;
    versor head, back;
    head_pose(o->head_deg, head);
    measure_head(head, out_sample);
    double openness;
    if (is_hidden(o, t_s, &openness)) {
        if (openness == 1) return;
        out_sample->valid = lid_bits;
        out_sample->eye[0].openness = out_sample->eye[1].openness = round_to(openness, scalar_steps);
        return;
    }
    gaze_at(o, t_s, gaze);
    glm_quat_inv(head, back);
    glm_quat_rotatev(back, gaze, gaze);
    measure_gaze(o, gaze, openness, out_sample);
    out_sample->valid = all_bits;
}
