/* SimpleFOC's motor as a law of stiction's ensembles: its sources are compiled unmodified beside
 * this file (`cargo xtask simplefoc DIR`).
 *
 * Alone, the motor runs SimpleFOC's own cascade (MotionControlType::angle). With WITH_STICTION it
 * runs stiction by its hook for custom motion control.
 *
 * Both run once a tick, on voltage, with the sensor's angle within a turn as a magnetic sensor has
 * it. The motor turns the joint without a gear, so its angles are those of the joint.
 */
#include "Arduino.h"

#include "BLDCMotor.h"

#include "stiction_law.h"

#ifdef WITH_STICTION
#include "stiction_motor.h"
#endif

thread_local uint32_t simulated_micros = 0;

namespace {

constexpr double TURN = 6.283185307179586;

/* A magnetic sensor that reads whole counts. */
class CountSensor : public Sensor {
  public:
    explicit CountSensor(double count) : count(count) {}
    float getSensorAngle() override {
        const double angle = counts * count;
        return static_cast<float>(angle - TURN * std::floor(angle / TURN));
    }
    int32_t counts = 0;

  private:
    double count;
};

/* A driver without phases: the joint takes the voltage of the q axis. */
class NoDriver : public BLDCDriver {
  public:
    explicit NoDriver(double largest) {
        voltage_power_supply = voltage_limit = static_cast<float>(largest);
        initialized = true;
    }
    int init() override { return 1; }
    void enable() override {}
    void disable() override {}
    void setPwm(float, float, float) override {}
    void setPhaseState(PhaseState, PhaseState, PhaseState) override {}
};

#ifndef WITH_STICTION
/* Gains of the cascade for a joint of known inertia J, by four constants.
 *
 *   PID_velocity: P = 2 pi f J, I = ri 2 pi f P;  P_angle: P = rp 2 pi f;  LPF_velocity: Tf
 */
struct Constants {
    double f = 20.0, rp = 0.25, ri = 0.25, tf = 0.005;
};

Constants constants() {
    Constants found;
    if (const char *text = std::getenv("SIMPLEFOC_CONSTANTS")) {
        char *next = const_cast<char *>(text);
        for (double *value : {&found.f, &found.rp, &found.ri, &found.tf}) {
            *value = std::strtod(next, &next);
            next += *next == ',';
        }
    }
    return found;
}
#endif

struct Joint {
    explicit Joint(const StictionLawJoint &facts)
        : facts(facts), sensor(facts.count), driver(facts.largest_effort), motor(1) {
        simulated_micros = 0;
        motor.linkDriver(&driver);
        motor.linkSensor(&sensor);
        motor.voltage_limit = static_cast<float>(facts.largest_effort);
        motor.sensor_direction = Direction::CW;
        motor.zero_electric_angle = 0;
        motor.torque_controller = TorqueControlType::voltage;
        /* A sketch has its motor in static memory, where these are zero. */
        motor.feed_forward_voltage = {0, 0};
        motor.feed_forward_current = {0, 0};
        motor.shaft_angle = motor.shaft_velocity = 0;
    }

    const StictionLawJoint facts;
    CountSensor sensor;
    NoDriver driver;
    BLDCMotor motor;
#ifdef WITH_STICTION
    Stiction stiction;
#endif
};

#ifdef WITH_STICTION
/* The joint whose tick this thread runs. */
thread_local Joint *running;

float positioned(FOCMotor *motor) {
    return stiction_motor(motor, &running->stiction, 1.0 / running->facts.count);
}

bool configure(Joint &joint) {
    const StictionLawJoint &facts = joint.facts;
    StictionConfig config = {};
    config.size = sizeof config;
    config.sample_time = static_cast<float>(facts.sample_time);
    config.counts_per_turn = static_cast<float>(TURN / facts.count);
    config.largest_effort = static_cast<float>(facts.largest_effort);
    config.effort_step = static_cast<float>(facts.effort_step);
    config.inertia = static_cast<float>(facts.inertia);
    config.viscous = static_cast<float>(facts.viscous);
    config.breakaway_low = static_cast<float>(facts.breakaway_low);
    config.breakaway_high = static_cast<float>(facts.breakaway_high);
    config.load = static_cast<float>(facts.load);
    config.hold_effort = static_cast<float>(facts.hold_effort);
    config.jitter = static_cast<float>(facts.jitter);
    config.encoder_side =
        facts.encoder_at_load ? STICTION_ENCODER_AT_LOAD : STICTION_ENCODER_AT_MOTOR;
    joint.motor.linkCustomMotionControl(positioned);
    joint.motor.controller = MotionControlType::custom;
    StictionRefusal why;
    return stiction_init(&joint.stiction, &config, &why) == STICTION_OK;
}
#else
bool configure(Joint &joint) {
    const Constants by = constants();
    const double rate = TURN * by.f;
    BLDCMotor &motor = joint.motor;
    motor.PID_velocity.P = static_cast<float>(rate * joint.facts.inertia);
    motor.PID_velocity.I = static_cast<float>(by.ri * rate) * motor.PID_velocity.P;
    motor.PID_velocity.D = 0;
    motor.P_angle.P = static_cast<float>(by.rp * rate);
    motor.LPF_velocity.Tf = static_cast<float>(by.tf);
    /* The set point is a profile: its speed is the limit. */
    motor.velocity_limit = 1000;
    motor.controller = MotionControlType::angle;
    return true;
}
#endif

} // namespace

extern "C" {

uint32_t stiction_law_abi(void) { return STICTION_LAW_ABI; }

const char *stiction_law_name(void) {
#ifdef WITH_STICTION
    return "simplefoc-stiction";
#else
    return "simplefoc-cascade";
#endif
}

const char *stiction_law_version(void) { return SIMPLEFOC_COMMIT; }

void *stiction_law_start(const StictionLawJoint *facts) {
    Joint *joint = new Joint(*facts);
    if (!configure(*joint)) {
        delete joint;
        return nullptr;
    }
    joint->motor.updateVoltageLimit(joint->motor.voltage_limit);
    joint->motor.updateVelocityLimit(joint->motor.velocity_limit);
    joint->motor.enabled = 1;
    joint->motor.motor_status = FOCMotorStatus::motor_ready;
    joint->motor.motion_downsample = 0;
    return joint;
}

double stiction_law_tick(void *controller, const StictionLawSample *sample) {
    Joint &joint = *static_cast<Joint *>(controller);
    simulated_micros += static_cast<uint32_t>(std::lround(joint.facts.sample_time * 1e6));
    joint.sensor.counts = sample->counts;
#ifdef WITH_STICTION
    running = &joint;
#endif
    BLDCMotor &motor = joint.motor;
    motor.feed_forward_velocity = static_cast<float>(sample->target_velocity);
    /* The sensor first, then the motion, then the voltage: no tick is lost between them. */
    joint.sensor.update();
    motor.move(static_cast<float>(sample->target_counts * joint.facts.count));
    motor.loopFOC();
    return motor.voltage.q;
}

#ifdef WITH_STICTION
/* stiction follows a path of its own where the set point is faster than the configuration lets it
 * be, so that it may be far behind: the limits of PD's gains are not its own. */
double stiction_law_following_error(const StictionLawJoint *) { return TURN; }
#endif

void stiction_law_end(void *controller) { delete static_cast<Joint *>(controller); }
}
