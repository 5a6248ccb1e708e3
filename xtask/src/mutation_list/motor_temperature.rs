//! Faults of the motor's temperature sensor.

use super::{Mutation, Suite, fault};

#[rustfmt::skip]
pub(super) const MUTATIONS: &[Mutation] = &[
    fault("src/safety/motor_temperature.rs",
        ["        Some(if temperature > limit {",
         "        Some(if false {"],
        "a motor beyond the limit of its NTC is no fault",
        Suite::Device, &["a_motor_beyond_its_limit_is_off_within_a_fifth_of_a_second"]),
    fault("src/safety/motor_temperature.rs",
        ["if mean < END || rest < END {",
         "if mean < END {"],
        "an open NTC is taken for a cold motor",
        Suite::Device, &["an_open_and_a_shorted_sensor_are_faults_and_a_disturbance_is_none"]),
    fault("src/safety/motor_temperature.rs",
        ["        state.open = 0;\n",
         ""],
        "disturbances of an NTC add up to a fault",
        Suite::Device, &["an_open_and_a_shorted_sensor_are_faults_and_a_disturbance_is_none"]),
    fault("src/safety/monitor/thermal.rs",
        ["            state.heat = state.heat.max(part * self.most);",
         "            state.heat = state.heat.max(0.0 * part);"],
        "an NTC does not correct the modelled heat",
        Suite::Device, &["a_motor_that_is_warm_when_power_returns_has_less_time_for_an_overload"]),
    fault("src/safety/monitor/thermal.rs",
        ["            state.heat = state.heat.max(part * self.most);",
         "            state.heat = part * self.most;"],
        "an NTC that shows the room cools the model",
        Suite::Device, &["a_cold_sensor_does_not_cool_the_model"]),
    fault("src/main.rs",
        ["                parts.servo.take_ntc(reading);\n",
         "                let _ = reading;\n"],
        "the board does not read its NTC",
        Suite::Image, &["an_image_measures_the_motor_as_a_simulated_device_does"]),
];
