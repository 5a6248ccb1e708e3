//! An arm on the bench: a servo with all of its monitors at each of its two joints, stepped tick by
//! tick.
//!
//! It is armed and moved as one joint is ([`super::rig`]). A fault of either servo ends the motion
//! of both.

use stiction::control::reference::Reference;
use stiction::safety::fault::Fault;

use super::draw::Case;
use super::measures::Sample;
use super::rig::{Amplified, armed};
use super::rules::Tuned;
use crate::error::Error;
use crate::joint::GearedArm;
use crate::target::Target as _;

/// Two servos and their arm.
#[derive(Debug)]
pub struct ArmRig {
    arm: GearedArm,
    joints: [Amplified; 2],
    sample_time_s: f64,
}

impl ArmRig {
    /// Arms a servo on each joint of an arm, and lets them hold it until their soft start is over.
    ///
    /// # Errors
    /// If there is no arm or no gains for both joints, gains are not allowed, or a servo refuses to
    /// be armed.
    pub fn armed(case: &Case, tuned: &[Tuned]) -> Result<Self, Error> {
        let (Some(second), [gains, gains_of_second]) = (&case.arm, tuned) else {
            return Err(Error::Input("an arm has two joints, and gains for both".into()));
        };
        let arm = second.arm.build()?;
        let arm = if second.is_coupled { arm } else { arm.without_coupling() };
        let at = |joint: usize| case.encoder.count_at(arm.turn(joint).position);
        let scale = [case.scale.effort, case.scale.angle];
        let (first, lead_in) = armed(case, &case.told, gains, at(0))?;
        let (other, _) = armed(case, &second.told, gains_of_second, at(1))?;
        let joints = [
            Amplified::new(first, &case.told, case.delay, scale),
            Amplified::new(other, &second.told, second.delay, scale),
        ];
        let mut rig = Self { arm, joints, sample_time_s: case.told.sample_time };
        for _ in 0..lead_in {
            rig.tick(case.encoder.count);
        }
        Ok(rig)
    }

    /// Has both servos follow a reference each from the next tick on; returns whether they do.
    #[must_use]
    pub fn follow(&mut self, references: [Reference; 2]) -> bool {
        let pairs = self.joints.iter_mut().zip(references);
        pairs.fold(true, |all, (joint, reference)| joint.servo.follow(reference).is_ok() && all)
    }

    /// Returns the fault that has ended the motion, if there was one.
    pub fn fault(&self) -> Option<Fault> {
        self.joints.iter().find_map(|joint| joint.servo.fault.map(|(latched, _)| latched.fault))
    }

    /// Runs a tick, and moves the arm on to the next one; returns where its joints were at the
    /// tick. `count` is the angle of a count, rad.
    pub fn tick(&mut self, count: f64) -> [Sample; 2] {
        let turns = [self.arm.turn(0), self.arm.turn(1)];
        let encoder = crate::joint::JointEncoder { count, side: crate::joint::DiscSide::Motor };
        let mut samples = [Sample::default(); 2];
        for ((joint, turn), sample) in self.joints.iter_mut().zip(turns).zip(&mut samples) {
            let tick = joint.servo.tick(encoder.count_at(turn.position) as u32);
            *sample =
                joint.sample(&tick.unwrap_or_default(), [turn; 2], [count, self.sample_time_s]);
        }
        self.arm.hold(samples.map(|sample| sample.effort), self.sample_time_s);
        samples
    }
}
