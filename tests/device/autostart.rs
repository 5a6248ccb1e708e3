//! Autostart after a reset that may have been a dip of the supply.

use files::hardware::STM32F405;
use stiction::Servo;
use stiction::servo::{Boot, Input, State};

use crate::fixture::srnf;

#[test]
fn a_reset_that_may_be_a_dip_arms_only_if_the_parameters_say_so() {
    for (may_be_dip, is_damaged, after_dip, arms) in [
        (false, false, false, true),
        (true, false, false, false),
        (true, false, true, true),
        (false, false, true, true),
        // What is said of dips says nothing of damage.
        (true, true, true, false),
        (false, true, true, false),
    ] {
        let after_dip = format!("device.autostart_after_dip={after_dip}");
        let parameters = srnf(&["device.autostart=true", &after_dip]);
        let boot = Boot { may_be_dip, is_damaged, ..Boot::default() };
        let mut servo = Servo::new(Ok(&parameters), boot, &STM32F405);
        // A second, and some ticks to be at rest.
        for _ in 0..60 {
            servo.tick(Input {
                counter: 0,
                supply: STM32F405.supply_top,
                lines: 0,
                ..Input::default()
            });
        }
        assert_eq!(servo.state() == State::Armed, arms, "{boot:?}, {after_dip}");
        // A command arms in every case.
        assert_eq!(servo.arm(), Ok(()));
    }
}
