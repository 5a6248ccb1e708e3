//! A bump of the motor: up to a twist at which the load slides, and back before it slides too far.
//!
//! The load rests, held by its friction, and the motor moves alone. It goes from `m_0` up by
//! `k_i D`, and down to `c`, each half by
//!
//! ```text
//! b(z) = 3 z^2 - 2 z^3,    0 <= z <= 1
//! T    = 2 sqrt(6 k_i D J_m / max(0.9 u_m - R_i, 0.2 u_m)),    12 to 200 ticks, half of them up
//! ```
//!
//! While the load moves with `l'`, the way down is shifted against that motion: the motor draws
//! back farther, and the spring releases the load.
//!
//! ```text
//! down:  b -= clamp(0.05 l', 0.7 S)
//! u    = J_m b'' + J_m w_b [w_b (b - y) + 1.8 (b' - y')] + R_b sat(2 b' T / (pi k_i D))
//! w_b  = g_b min(100, 0.14 / h),   y' = (y_k - y_{k-2}) / 2h
//! ```
//!
//! `J_m` and `R_b` are the motor's own inertia and friction, learned from bumps
//! ([`bump_memory`](super::bump_memory)). The largest acceleration of the cubic is `6 k_i D /
//! (T/2)^2`, hence `T`: the largest effort, less friction and a reserve, accelerates the motor by
//! this much.
//!
//! Afterwards the motor is held at `c`. When the load rests, the motor is moved to `l + N`, for 30
//! ticks at most, so that it comes to rest without torque in the gear:
//!
//! ```text
//! u = J_m w_b (w_b d - 1.8 y') + R_b g_b sat(d / d_w) + g_b u_i,    d_w = max(2 q_m, 0.08 S)
//! ```
//!
//! with `d` the distance to go, and `u_i` an effort that grows by `50 R_b` a second where the
//! motor sticks before `d_w`, and fades within it.
//!
//! Why this form: a pulse on the motor winds the gear up and leaves it wound up, so that the load
//! goes as far as the spring moves it. A bump reduces the twist while the load slides. The smallest
//! slide is then that of a motor that draws back as fast as it can, a ninetieth of the jump in the
//! median of soft gears.
//!
//! Guarantees: `b` stays within `[m_0, m_0 + k_i D]` and `c`, except by the distance that it draws
//! back; the length is bounded. Does badly: a load so light, or friction that falls so much at the
//! breakaway, that the motor cannot draw back in time.

use crate::units::saturation::bounded;

/// Shortest and longest bump, ticks.
const SHORTEST: u16 = 12;
const LONGEST: u16 = 200;

/// Factor of b' T / 2 D: the whole friction is requested from half the largest speed of a raised
/// cosine on, which is `pi/2` times the mean speed `2 D / T`. The factor is 4/pi, rounded as in the
/// prototype.
const FULL_FROM: f32 = 1.273_885;

/// Ticks for which the motor is moved back after the load has come to rest.
const LEAD_BACK: u8 = 30;

/// Bumps, prepared for a joint and a sample time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorBump {
    sample_time: f32,
    per_sample_time: f32,
    /// Largest effort u_m, V.
    limit: f32,
    /// Bandwidth of the motor's loop, rad/s.
    bandwidth: f32,
    /// Angle of a count of the motor's encoder q_m, deg.
    pub motor_count: f32,
    /// Largest effort u_i that moves the motor back, beside the loop, V.
    most_led: f32,
}

/// Request for a bump.
#[derive(Clone, Copy, Debug)]
pub struct Wanted {
    /// Positions at which motor and load rest, deg.
    pub from: [f32; 2],
    /// Travel D of the way up, with its sign, deg.
    pub way: f32,
    /// Position c at which the way down ends, deg.
    pub end: f32,
    /// Factor k_i from the travel to the commanded travel of the motor.
    pub gain: f32,
    /// Sliding friction R_i, V.
    pub friction: f32,
}

/// Model of the motor, learned from bumps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorModel {
    /// Inertia J_m, V s^2/deg.
    pub inertia: f32,
    /// Friction R_b, V.
    pub friction: f32,
    /// Gain g_b of the motor's loop in a bump.
    pub gain: f32,
}

/// The bump that runs, or the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BumpState {
    /// Positions at which motor and load rested, deg.
    pub from: [f32; 2],
    /// Travel of the way up, with its sign, and the commanded travel (positive), deg.
    pub way: f32,
    asked: f32,
    /// Position at which the way down ends, deg.
    end: f32,
    /// Farthest travel of the motor so far, deg.
    pub peak: f32,
    /// Largest speed on the way up, deg/s.
    pub speed: f32,
    /// Impulse until that speed, less that of the friction, V s.
    pub impulse: f32,
    impulse_so_far: f32,
    /// Efforts of the last two ticks, V.
    efforts: [f32; 2],
    /// Effort u_i that moves the motor back, V.
    led: f32,
    ticks: u16,
    /// Ticks of the way up, and of the whole.
    up: u16,
    length: u16,
    /// Ticks for which the motor has been moved back.
    led_ticks: u8,
    /// Whether the load has come to rest after the bump.
    load_rests: bool,
}

/// Inputs of a bump in a tick.
#[derive(Clone, Copy, Debug)]
pub struct MotorSeen {
    /// Position y of the motor, deg.
    pub position: f32,
    /// Speed y' of the motor, deg/s.
    pub speed: f32,
    /// Speed of the load l', deg/s.
    pub load_speed: f32,
    /// Half the width S of the range of twists, deg.
    pub half_width: f32,
}

/// A place on the path, with its derivatives.
struct Place {
    position: f32,
    speed: f32,
    acceleration: f32,
}

impl MotorBump {
    /// Prepares bumps for ticks of `sample_time` (s), the largest effort (V), the angle of a count
    /// of the motor's encoder (deg), and the highest breakaway effort (V).
    pub fn new(sample_time: f32, limit: f32, motor_count: f32, high: f32) -> Self {
        Self {
            sample_time,
            per_sample_time: 1.0 / sample_time,
            limit,
            bandwidth: (0.14 / sample_time).min(100.0),
            motor_count,
            most_led: high,
        }
    }

    /// Plans a bump.
    pub fn plan(&self, wanted: &Wanted, motor: &MotorModel) -> BumpState {
        let asked = wanted.way.abs() * wanted.gain;
        let effort = (0.9 * self.limit - wanted.friction).max(0.2 * self.limit);
        let time = 2.0 * libm::sqrtf(6.0 * asked * motor.inertia / effort);
        let ticks = libm::ceilf(time * self.per_sample_time) as u16;
        let up = ticks.clamp(SHORTEST, LONGEST) / 2;
        BumpState {
            from: wanted.from,
            way: wanted.way,
            asked,
            end: wanted.end,
            peak: f32::NEG_INFINITY,
            up,
            length: 2 * up,
            ..BumpState::default()
        }
    }

    /// Runs a tick of a bump. Returns the effort (V), and whether the bump is over.
    pub fn update(
        &self,
        bump: &mut BumpState,
        motor: &MotorModel,
        seen: &MotorSeen,
        friction: f32,
    ) -> (f32, bool) {
        let sign = if bump.way > 0.0 { 1.0 } else { -1.0 };
        let mut place = self.place(bump, sign);
        if bump.ticks < bump.up {
            self.measure(bump, motor, sign * seen.speed, sign, friction);
        } else {
            place.position -= bounded(0.05 * seen.load_speed, 0.7 * seen.half_width);
        }
        let bandwidth = self.bandwidth * motor.gain;
        // The whole friction is requested from half of the path's largest speed on.
        let direction =
            place.speed * FULL_FROM * f32::from(bump.up) * self.sample_time / bump.asked;
        let effort = motor.inertia * place.acceleration
            + motor.inertia
                * bandwidth
                * (bandwidth * (place.position - seen.position) + 1.8 * (place.speed - seen.speed))
            + motor.friction * bounded(direction, 1.0);
        bump.efforts = [bounded(effort, self.limit), bump.efforts[0]];
        bump.note(sign, seen.position);
        bump.ticks = bump.ticks.saturating_add(1);
        (effort, bump.ticks >= bump.length)
    }

    /// Holds the motor after a bump until the load rests, and then moves it to `neutral`, deg from
    /// the load. Returns the effort (V), and whether the motor is still on its way to `neutral`.
    pub fn hold(
        &self,
        bump: &mut BumpState,
        motor: &MotorModel,
        seen: &MotorSeen,
        rested_at: Option<f32>,
        neutral: f32,
    ) -> (f32, bool) {
        let bandwidth = self.bandwidth * motor.gain;
        if let Some(load) = rested_at
            && !bump.load_rests
        {
            bump.load_rests = true;
            bump.led = 0.0;
            bump.end = load + neutral;
        }
        let within = (2.0 * self.motor_count).max(0.08 * seen.half_width);
        let mut ahead = bump.end - seen.position;
        let mut waits = false;
        if bump.load_rests {
            if bump.led_ticks >= LEAD_BACK {
                ahead = 0.0;
            }
            if ahead.abs() <= within {
                bump.led *= 0.9;
            } else {
                let sign = if ahead > 0.0 { 1.0 } else { -1.0 };
                let step = sign * motor.friction * self.sample_time * 50.0;
                bump.led = bounded(bump.led + step, self.most_led);
                waits = true;
            }
        } else {
            ahead -= bounded(0.05 * seen.load_speed, 0.7 * seen.half_width);
        }
        let effort = motor.inertia * bandwidth * (bandwidth * ahead - 1.8 * seen.speed)
            + motor.friction * motor.gain * bounded(ahead / within, 1.0)
            + bump.led * motor.gain;
        if !bump.load_rests {
            bump.note(if bump.way > 0.0 { 1.0 } else { -1.0 }, seen.position);
        }
        (effort, waits)
    }

    /// Returns the place of the path at the bump's tick.
    fn place(&self, bump: &BumpState, sign: f32) -> Place {
        let top = bump.from[0] + sign * bump.asked;
        let is_up = bump.ticks < bump.up;
        let (from, to) = if is_up { (bump.from[0], top) } else { (top, bump.end) };
        let ticks = f32::from(bump.up);
        let at = f32::from(if is_up { bump.ticks } else { bump.ticks - bump.up }) / ticks;
        let z = if at < 1.0 { at } else { 1.0 };
        let (way, time) = (to - from, ticks * self.sample_time);
        Place {
            position: from + way * z * z * (3.0 - 2.0 * z),
            speed: way * 6.0 * z * (1.0 - z) / time,
            acceleration: if z < 1.0 { way * 6.0 * (1.0 - 2.0 * z) / (time * time) } else { 0.0 },
        }
    }

    /// Adds the impulse of a tick on the way up, and stores the impulse at the largest speed.
    fn measure(
        &self,
        bump: &mut BumpState,
        motor: &MotorModel,
        speed: f32,
        sign: f32,
        friction: f32,
    ) {
        let against = motor.friction.min(0.6 * friction);
        bump.impulse_so_far += self.sample_time * (sign * bump.efforts[1] - against);
        if speed > bump.speed {
            bump.speed = speed;
            bump.impulse = bump.impulse_so_far;
        }
    }
}

impl BumpState {
    /// Counts a tick in which the motor is moved back, and returns whether more remain.
    pub const fn count_led_tick(&mut self) -> bool {
        self.led_ticks = self.led_ticks.saturating_add(1);
        self.led_ticks < LEAD_BACK
    }

    /// Stores the farthest travel of the motor.
    fn note(&mut self, sign: f32, position: f32) {
        self.peak = self.peak.max(sign * (position - self.from[0]));
    }

    /// Returns a bump whose path is over; from now on the motor is held at `end`.
    pub fn led_back(from: [f32; 2], sign: f32, end: f32) -> Self {
        Self { from, way: sign, asked: 1.0, end, ..Self::default() }
    }

    /// Moves the origins, deg: of the motor, and of the load.
    pub fn rebase(&mut self, motor: f32, load: f32) {
        self.from[0] -= motor;
        self.from[1] -= load;
        self.end -= motor;
    }
}
