/* A joint that sticks, positioned through stiction.h. It runs on a computer and on a
 * microcontroller alike, and prints each tick: `cargo xtask test` compares the two. */
#include "stiction.h"

#include "platform.h"

#define TICKS 4000
#define COUNTS_PER_TURN 100000.0f
#define TURN 6.2831855f

/* A rigid joint with static friction 2.4 and sliding friction 2, a fifth lighter than configured.
 * Position in counts, speed in rad/s. */
typedef struct {
    float position;
    float speed;
} Joint;

static float absolute(float x) {
    return x < 0.0f ? -x : x;
}

static float sign(float x) {
    return x < 0.0f ? -1.0f : 1.0f;
}

static int32_t counter(const Joint *joint) {
    int32_t whole = (int32_t)joint->position;
    return (float)whole > joint->position ? whole - 1 : whole;
}

/* Moves for 1 ms in steps of 50 us. */
static void advance(Joint *joint, float effort) {
    for (int i = 0; i < 20; i++) {
        float before = joint->speed;
        float force = effort - 0.9f * before;
        if (before == 0.0f && absolute(force) <= 2.4f) {
            continue;
        }
        float friction = 2.0f * sign(before == 0.0f ? force : before);
        joint->speed += (force - friction) / 0.1f * 5e-5f;
        if (before != 0.0f && joint->speed * before <= 0.0f) {
            joint->speed = 0.0f;
        }
        joint->position += joint->speed * (COUNTS_PER_TURN / TURN) * 5e-5f;
    }
}

static uint32_t bits(float x) {
    union {
        float number;
        uint32_t bits;
    } both = {x};
    return both.bits;
}

static void print(uint32_t effort, int32_t counts, int32_t mode) {
    char line[20];
    uint32_t words[2] = {effort, (uint32_t)counts};
    for (int i = 0; i < 16; i++) {
        uint32_t digit = words[i / 8] >> (28 - 4 * (i % 8)) & 15;
        line[i] = (char)(digit < 10 ? '0' + digit : 'a' + digit - 10);
    }
    line[16] = ' ';
    line[17] = (char)('0' + mode);
    line[18] = '\n';
    line[19] = 0;
    say(line);
}

/* In each struct the caller owns the memory. */
static Stiction stiction;
static StictionMonitors monitors;

static int failed(const char *why) {
    say(why);
    return 1;
}

int program(void) {
    StictionConfig config = {
        .size = sizeof config,
        .sample_time = 1e-3f,
        .counts_per_turn = COUNTS_PER_TURN,
        .largest_effort = 16.0f,
        .effort_step = 0.015625f,
        .inertia = 0.12f,
        .viscous = 0.9f,
        .breakaway_low = 0.9f,
        .breakaway_high = 3.0f,
        .encoder_side = STICTION_ENCODER_AT_MOTOR,
    };
    StictionMonitorConfig watch = {
        .size = sizeof watch,
        .range_low = -1.0f,
        .range_high = 1.0f,
        .continuous_effort = 6.0f,
        .thermal_time = 10.0f,
    };
    StictionRefusal why;
    StictionConfig wrong = config;
    wrong.breakaway_high = 30.0f;
    if (stiction_init(&stiction, &wrong, &why) != STICTION_REFUSED || why.found != 30.0f) {
        return failed("a wrong configuration is not refused\n");
    }
    if (stiction_init(&stiction, &config, &why) != STICTION_OK ||
        stiction_monitors_init(&monitors, &config, &watch, 0, &why) != STICTION_OK) {
        return failed("the configuration is refused\n");
    }
    Joint joint = {0.0f, 0.0f};
    float effort = 0.0f;
    StictionTarget target;
    stiction_target(&stiction, 0.3f, &target);
    /* A step of 0.3 rad, a slow ramp of 20 counts/s for 1 s, and a step back. */
    for (int tick = 0; tick < TICKS; tick++) {
        int32_t counts = counter(&joint);
        if (tick < 1500) {
            effort = stiction_tick(&stiction, counts, 0.3f);
        } else if (tick < 2500) {
            target.velocity = 20.0f / COUNTS_PER_TURN * TURN;
            target.fraction += 0.02f;
            if (target.fraction >= 1.0f) {
                target.fraction -= 1.0f;
                target.counts += 1;
            }
            effort = stiction_follow(&stiction, counts, &target);
        } else {
            stiction_target(&stiction, -0.2f, &target);
            effort = stiction_follow_applied(&stiction, counts, &target, effort);
        }
        if (stiction_monitors_check(&monitors, counts, &target, effort, 0) != STICTION_NO_FAULT) {
            return failed("a joint that works trips a monitor\n");
        }
        print(bits(effort), counts, stiction_mode(&stiction));
        advance(&joint, effort);
    }
    float error = joint.position + 0.2f / TURN * COUNTS_PER_TURN;
    return absolute(error) <= 2.0f ? 0 : failed("the joint is not within two counts\n");
}
