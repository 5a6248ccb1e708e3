/* A joint that sticks, positioned by stiction within SimpleFOC 2.4 or later.
 *
 * Put stiction.h and libstiction.a (`cargo xtask library`) into an Arduino library named stiction,
 * and stiction_motor.h beside this sketch. It was compiled for no board and ran on none: the
 * function in stiction_motor.h was run around simulated joints by `cargo xtask simplefoc`.
 *
 * A law stops no runaway. Limit travel, time and current yourself, or add the StictionMonitors.
 */
#include <SimpleFOC.h>

#include "stiction_motor.h"

BLDCMotor motor = BLDCMotor(7);
BLDCDriver3PWM driver = BLDCDriver3PWM(9, 10, 11, 8);
Encoder encoder = Encoder(2, 3, 2048);

static Stiction stiction;
static const float COUNTS_PER_TURN = 4 * 2048;
static const uint32_t SAMPLE_TIME_US = 1000;

void onA() { encoder.handleA(); }
void onB() { encoder.handleB(); }

float positioned(FOCMotor *m) { return stiction_motor(m, &stiction, COUNTS_PER_TURN / _2PI); }

void setup() {
    Serial.begin(115200);
    encoder.init();
    encoder.enableInterrupts(onA, onB);
    motor.linkSensor(&encoder);
    driver.voltage_power_supply = 24;
    driver.init();
    motor.linkDriver(&driver);
    motor.voltage_limit = 12;

    StictionConfig config = {};
    config.size = sizeof config;
    config.sample_time = 1e-6f * SAMPLE_TIME_US;
    config.counts_per_turn = COUNTS_PER_TURN;
    config.largest_effort = motor.voltage_limit;
    config.effort_step = 0.01f;
    config.inertia = 0.02f;        /* V for 1 rad/s^2 */
    config.viscous = 0.1f;         /* V for 1 rad/s, with back-EMF */
    config.breakaway_low = 0.3f;   /* V: lowest over all positions */
    config.breakaway_high = 1.0f;  /* V: highest over all positions */
    StictionRefusal why;
    if (stiction_init(&stiction, &config, &why) != STICTION_OK) {
        Serial.println(why.field);
        return;
    }
    motor.linkCustomMotionControl(positioned);
    motor.controller = MotionControlType::custom;
    motor.torque_controller = TorqueControlType::voltage;
    if (motor.init() && motor.initFOC()) {
        motor.target = 1.0f;
    } else {
        motor.disable();
    }
}

void loop() {
    static uint32_t last = micros();
    motor.loopFOC();
    const uint32_t waited = micros() - last;
    if (waited >= 2 * SAMPLE_TIME_US) {
        /* Too late: the law has not seen what happened, and begins anew. */
        stiction_restart(&stiction);
        last += waited;
        motor.move();
    } else if (waited >= SAMPLE_TIME_US) {
        last += SAMPLE_TIME_US;
        motor.move();
    }
}
