//! Bounds of the joint of a machine's file, for the rule book.

use super::plan::RunPlan;
use crate::rules::{JointBounds, JointEstimate, SampledLoop};
use files::error::Error;

impl RunPlan {
    /// Returns the bounds of this run's joint, from the data sheet or `[joint]`. The file's
    /// `[spread]` widens them: by its lowest slip friction, highest stick friction and largest
    /// unbalance, and for a gear between two encoders by its lowest stiffness and largest slack.
    /// The viscous friction has no back-EMF if the efforts are currents.
    ///
    /// # Errors
    /// Returns an error that names the invalid value.
    pub fn joint_bounds(&self) -> Result<JointBounds, Error> {
        let bounds = self.bounds_without_current_loop()?;
        match self.winding()? {
            Some(winding) if self.has_current_loop() => {
                Ok(bounds.with_current_loop(winding.back_emf_v_per_deg_per_s))
            }
            _ => Ok(bounds),
        }
    }

    fn bounds_without_current_loop(&self) -> Result<JointBounds, Error> {
        let machine = &self.machine;
        // A value that was set outside of its range widens it.
        let end = |key: &str, end: usize, value: f64| match machine.spread.get(key) {
            Some(ends) if end == 0 => value.min(ends[0]),
            Some(ends) => value.max(ends[1]),
            None => value,
        };
        let sampled = SampledLoop {
            largest_effort: machine.drive.full_scale_v()
                * machine.drive.number("duty_max").unwrap_or(1.0),
            lsb: machine.drive.lsb_v(),
            count: machine.count_deg(),
            sample_time: machine.sampling.sample_time_s(),
        };
        let Some((mut sheet, mapping)) = self.sheet()? else {
            let friction = &machine.joint.friction;
            let slip = end("joint.friction.slip_v", 0, friction.slip_v);
            let estimate = JointEstimate {
                inertia: 1.0 / machine.joint.gain_deg_per_s2_per_v,
                viscous: machine.joint.viscous_v_per_deg_per_s,
                friction: [slip, end("joint.friction.stick_v", 1, friction.stick_v)],
                load: 0.0,
                holds: slip,
            };
            let bounds = JointBounds::of(&estimate, sampled);
            return Ok(match self.motor_encoder_of_a_device()? {
                Some(motor) => bounds.with_motor_encoder(motor.count.into()),
                None => bounds,
            });
        };
        sheet.friction.slip_nm = end("friction.slip_nm", 0, sheet.friction.slip_nm);
        sheet.friction.stick_nm = end("friction.stick_nm", 1, sheet.friction.stick_nm);
        sheet.load.unbalance_nm = end("load.unbalance_nm", 1, sheet.load.unbalance_nm);
        let gear = &mut sheet.gear;
        for (value, key, side) in [
            (&mut gear.stiffness_nm_per_rad, "gear.stiffness_nm_per_rad", 0),
            (&mut gear.stiffness_nm_per_deg, "gear.stiffness_nm_per_deg", 0),
            (&mut gear.backlash_rad, "gear.backlash_rad", 1),
            (&mut gear.backlash_deg, "gear.backlash_deg", 1),
        ] {
            *value = value.map(|value| end(key, side, value));
        }
        let estimate = JointEstimate::of_sheet(&sheet, &mapping);
        let count_deg = machine.encoder.resolution_deg();
        Ok(JointBounds::of(&estimate, sampled).with_encoders_of(&sheet, &mapping, count_deg))
    }
}
