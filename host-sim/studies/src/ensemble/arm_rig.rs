//! An arm on the bench: a servo with all of its monitors at each of its two joints, stepped tick by
//! tick.
//!
//! The arm is armed and moved as a single joint is ([`super::rig`]). A fault of either servo ends
//! the motion of both.

use stiction::control::reference::Reference;
use stiction::safety::fault::Fault;

use super::drawn_case::Case;
use super::measures::CaseSample;
use super::motions::Approach;
use super::rig::{Amplified, armed, failure};
use dynamics::joint::GearedArm;
use files::error::Error;
use simulator::counters::Counters;
use simulator::rules::{ControllerGains, JointBounds};
use simulator::target::Target as _;

/// Two servos and their arm.
#[derive(Debug)]
pub struct ArmRig {
    arm: GearedArm,
    joints: [Amplified; 2],
    bounds: [JointBounds; 2],
    /// Positions at arming, counts.
    armed_at: [i64; 2],
    sample_time_s: f64,
}

impl ArmRig {
    /// Arms a servo on each joint of an arm. They hold the arm until their soft start is over.
    ///
    /// # Errors
    /// If there is no arm or no gains for both joints, gains are not allowed, or a servo refuses to
    /// be armed.
    pub fn armed(case: &Case, gains: &[ControllerGains]) -> Result<Self, Error> {
        let (Some(second), [gains, gains_of_second]) = (&case.arm, gains) else {
            return Err(Error::Input("an arm has two joints, and gains for both".into()));
        };
        let arm = second.arm.build()?;
        let arm = if second.is_coupled { arm } else { arm.without_coupling() };
        let at = |joint: usize| case.encoder.count_at(arm.turn(joint).position);
        let scale = [case.scale.effort, case.scale.angle];
        let armed_at = [at(0), at(1)];
        let at_rest = |counts: i64| Counters::one(counts as u32);
        let first = armed(case, &case.bounds, gains, at_rest(armed_at[0]))?;
        let other = armed(case, &second.bounds, gains_of_second, at_rest(armed_at[1]))?;
        let lead_in = first.lead_in;
        let joints = [
            Amplified::new(first.servo, &case.bounds, case.delay, scale),
            Amplified::new(other.servo, &second.bounds, second.delay, scale),
        ];
        let bounds = [case.bounds, second.bounds];
        let sample_time_s = case.bounds.sampled.sample_time;
        let mut rig = Self { arm, joints, bounds, armed_at, sample_time_s };
        for _ in 0..lead_in {
            rig.step(case.encoder.count);
        }
        Ok(rig)
    }

    /// Commands each servo to follow its reference from the next tick on; returns whether both do.
    #[must_use]
    pub fn follow(&mut self, references: [Reference; 2]) -> bool {
        let pairs = self.joints.iter_mut().zip(references);
        pairs.fold(true, |all, (joint, reference)| joint.servo.follow(reference).is_ok() && all)
    }

    /// Returns the positions at arming, counts.
    pub fn armed_at(&self) -> [f64; 2] {
        self.armed_at.map(|counts| counts as f64)
    }

    /// Commands each servo to go to its target, in counts from its position at arming.
    ///
    /// # Errors
    /// If the core refuses the limits of a profile.
    pub fn go_to(&mut self, approach: Approach, to: [f64; 2]) -> Result<(), Error> {
        for ((joint, to), bounds) in self.joints.iter_mut().zip(to).zip(&self.bounds) {
            approach.start(&mut joint.servo, to, bounds)?;
        }
        Ok(())
    }

    /// Returns the fault that has ended the motion, if there was one.
    pub fn fault(&self) -> Option<Fault> {
        self.joints.iter().find_map(|joint| joint.servo.fault.map(|(latched, _)| latched.fault))
    }

    /// Returns what makes the motion a failure, if anything does: a fault, or a motion that the
    /// simulation could not follow.
    pub fn failure(&self) -> Option<String> {
        failure(self.fault(), self.arm.unfollowed_s())
    }

    /// Runs a tick, and moves the arm on to the next one; returns the samples of both joints at the
    /// tick. `count` is the angle of a count, rad.
    pub fn step(&mut self, count: f64) -> [CaseSample; 2] {
        let turns = [self.arm.turn(0), self.arm.turn(1)];
        let encoder =
            dynamics::joint::JointEncoder { count, side: dynamics::joint::DiscSide::Motor };
        let mut samples = [CaseSample::default(); 2];
        for ((joint, turn), sample) in self.joints.iter_mut().zip(turns).zip(&mut samples) {
            let tick = joint.servo.tick(Counters::one(encoder.count_at(turn.position) as u32));
            *sample =
                joint.sample(&tick.unwrap_or_default(), [turn; 2], [count, self.sample_time_s]);
        }
        self.arm.hold(samples.map(|sample| sample.effort), self.sample_time_s);
        samples
    }
}
