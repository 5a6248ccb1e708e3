//! Memory of the bumps: what they show of the motor, and of the twist at which the load slides.
//!
//! In the direction `i` with the sign `s`, a bump began at the twist `w` and moved the load by `m`.
//! It was planned with its peak at `P`, for the travel `x`.
//!
//! ```text
//! x = |e|, but where |e| < 0.8 m_min,i:  |e| + c max(m_min,-i, 4 q),  c = 1.1 to 1.7
//! P = P_i + s (x - m_i) / g_i            from the last bump that way, else W_i + s x / 4 g_i
//! |P - W_i| <= (1 to 1.8) S,             |P - N| >= 0.97 |d_i - N|
//! ```
//!
//! `m_min` is about the smallest travel seen. A nearer target cannot be reached from this side: the
//! bump goes past it by a travel that a bump from the other side can make. The figures with a range
//! vary by the golden ratio, so that no two bumps in a row fail alike.
//!
//! ```text
//! motor:  J_m += (clamp(impulse / speed, J_m/2, 2 J_m) - J_m) / 2,    k_i *= 1 + 0.7 (f - 1)
//!         f = clamp(wanted / measured peak, 0.5, 1.6)
//!         it stuck (peak < 0.3 of the wanted one):  R_b *= 1.25,  J_m *= 1.2
//! load:   kicked back (2 q on its way, none at rest):  rho += 0.15, and four in a row: pulses
//!         no travel:  W_i = P + s max(0.08 S min(n, 5), q)
//!         else        g_i by the secant of two bumps, 0.3 to 3;  W_i halfway to P - s m / g_i
//! ```
//!
//! Why this form: the travel grows with the peak from the level `W_i` on, and no other property of
//! the gear is required. Every figure is measured, and has bounds.
//!
//! `R_b` shrinks by 0.85 where the motor went a third too far. Where `k_i` exceeds 2, `J_m` grows
//! by a quarter instead.
//!
//! Guarantees: `J_m`, `R_b`, `k_i`, `g_i` and `rho` stay within bounds, whatever a bump did. Does
//! badly: values learned at one place are wrong at another, so a new motion discards the travel and
//! the gains.

use super::motor_bump::{BumpState, MotorModel};
use super::twist_levels::TwistState;

/// The golden ratio: multiples of it are spread evenly over a unit.
const GOLDEN: f32 = 0.618_034;

/// Number of kicks in a row after which pulses are tried, and number of these pulses.
const KICKS: u8 = 4;
const PULSES: u8 = 4;

/// Bounds of R_b, J_m and the counts, prepared for a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BumpMemory {
    /// Inertia J of the whole joint, V s^2/deg.
    inertia: f32,
    /// Range of breakaway efforts, V.
    breakaway: [f32; 2],
    /// First friction of the motor, V.
    friction: f32,
    /// First inertia of the motor, V s^2/deg.
    first_inertia: f32,
    /// Angle of one count of the load's encoder, and of the motor's, deg.
    count: f32,
    motor_count: f32,
    /// Half width of the range of twists from which bumps are tried, deg.
    soft_from: f32,
}

/// Values learned of the load, from bumps in one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Learned {
    /// Factor k_i on the motor's travel.
    pub gain: f32,
    /// Travel of the load per twist, g_i.
    per_twist: f32,
    /// Twist and travel of the last bump that moved the load, P_i and m_i, deg. No travel: none.
    peak: f32,
    travel: f32,
    /// About the smallest travel seen, m_min, deg; 0: none.
    least: f32,
    /// Bumps in a row without travel.
    without: u8,
}

/// Values learned from bumps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MemoryState {
    /// Model of the motor.
    pub motor: MotorModel,
    /// Values of the load: backwards and forwards.
    pub learned: [Learned; 2],
    /// Distance rho beyond the neutral twist at which a bump leaves the motor, in parts of S.
    pub overshoot: f32,
    /// Half width of the range of twists from which bumps are tried, deg.
    soft_from: f32,
    /// Pulses that are left before the next bump.
    pub pulses: u8,
    kicks: u8,
    /// Pulses of this motion that moved the load by no count.
    silent: u8,
    /// Number of bumps, for the figures that vary.
    bumps: u8,
}

/// Result of a bump.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// Sign of its direction.
    pub sign: f32,
    /// Travel of the load from rest to rest, deg.
    pub moved: f32,
    /// Farthest travel of the load on its way, deg.
    pub peak: f32,
    /// Half the width S of the range of twists, deg.
    pub half_width: f32,
}

/// Returns a figure from 0 to 1 that varies from bump to bump.
fn varied(bumps: u8) -> f32 {
    let at = GOLDEN * f32::from(bumps & 63);
    at - libm::floorf(at)
}

impl BumpMemory {
    /// Prepares the memory of the bumps for a joint. The arguments: inertia of the joint and of its
    /// motor alone (0: unknown), V s^2/deg; lowest and highest breakaway effort, V; angle of one
    /// count of the load's encoder and of the motor's, deg.
    pub fn new(
        [inertia, of_motor]: [f32; 2],
        breakaway: [f32; 2],
        [count, motor_count]: [f32; 2],
    ) -> Self {
        let [low, high] = breakaway;
        Self {
            inertia,
            breakaway,
            friction: 0.5 * 0.8 * libm::sqrtf(low * high),
            first_inertia: if of_motor > 0.0 { of_motor } else { 0.2 * inertia },
            count,
            motor_count,
            soft_from: 9.0 * count,
        }
    }

    /// Returns the initial memory, with nothing learned.
    pub fn start(&self) -> MemoryState {
        let motor = MotorModel { inertia: self.first_inertia, friction: self.friction, gain: 1.0 };
        let mut memory = MemoryState { motor, ..MemoryState::default() };
        self.forget_place(&mut memory);
        memory
    }

    /// Discards the values that were learned at one place. The motor's inertia stays, and its
    /// friction, which is at least the first one.
    pub fn forget_place(&self, memory: &mut MemoryState) {
        let motor = MotorModel {
            gain: 1.0,
            friction: memory.motor.friction.max(self.friction),
            ..memory.motor
        };
        let learned = Learned { gain: 1.0, per_twist: 0.7, ..Learned::default() };
        *memory = MemoryState {
            motor,
            learned: [learned; 2],
            overshoot: 0.3,
            soft_from: self.soft_from,
            bumps: memory.bumps,
            ..MemoryState::default()
        };
    }

    /// Returns whether the gear is so soft that the joint is moved by bumps.
    pub fn is_soft(&self, memory: &MemoryState, half_width: f32) -> bool {
        half_width > memory.soft_from && memory.pulses == 0
    }

    /// Returns the travel that a bump for an error is planned for, deg.
    pub fn travel(&self, memory: &MemoryState, error: f32) -> f32 {
        let size = error.abs();
        let forward = usize::from(error > 0.0);
        let least = memory.learned[forward].least;
        if least > 0.0 && size < 0.8 * least {
            let back = memory.learned[1 - forward].least.max(4.0 * self.count);
            size + (1.1 + 0.6 * varied(memory.bumps)) * back
        } else {
            size
        }
    }

    /// Returns the peak of the twist that moves the load by a travel, deg.
    pub fn peak(
        &self,
        memory: &mut MemoryState,
        levels: &TwistState,
        sign: f32,
        travel: f32,
    ) -> f32 {
        let forward = sign > 0.0;
        let Learned { per_twist, peak, travel: last, .. } = memory.learned[usize::from(forward)];
        let level = levels.breakaway[usize::from(forward)];
        let mut wanted = if last > 0.0 {
            peak + sign * (travel - last) / per_twist
        } else {
            level + sign * travel / per_twist * 0.25
        };
        let most = level + sign * (1.0 + 0.8 * varied(memory.bumps)) * levels.half_width();
        memory.bumps = memory.bumps.wrapping_add(1);
        if (wanted - most) * sign > 0.0 {
            wanted = most;
        }
        if let Some(least) = levels.least_peak(forward)
            && (wanted - least) * sign < 0.0
        {
            wanted = least;
        }
        wanted
    }

    /// Updates the memory after a pulse at rest; `is_silent`: the pulse moved the load by no count.
    /// A gear on which pulses have no effect is softer than it seems: after six of them, bumps are
    /// tried from half the width of the range on.
    pub fn pulse(&self, memory: &mut MemoryState, is_silent: bool) {
        if is_silent {
            memory.silent += 1;
            if memory.silent >= 6 {
                memory.silent = 0;
                memory.soft_from = (0.5 * memory.soft_from).max(2.0 * self.count);
            }
        }
    }

    /// Learns from a bump after which both sides have come to rest.
    pub fn learn(
        &self,
        memory: &mut MemoryState,
        levels: &mut TwistState,
        bump: &BumpState,
        outcome: &Outcome,
        sample_time: f32,
    ) {
        let Outcome { sign, moved, peak, half_width } = *outcome;
        let forward = usize::from(sign > 0.0);
        self.learn_motor(memory, bump, forward, sample_time);
        let [motor, load] = bump.from;
        // The largest twist, had the load not moved.
        let twist = motor + sign * bump.peak.max(0.0) - load;
        let MemoryState { learned, overshoot, pulses, kicks, .. } = memory;
        let learned = &mut learned[forward];
        let level = &mut levels.breakaway[forward];
        if moved < 0.6 * self.count && peak > 2.0 * self.count {
            *overshoot = (*overshoot + 0.15).min(1.0);
            *kicks += 1;
            if *kicks >= KICKS {
                (*kicks, *pulses) = (0, PULSES);
            }
        } else if moved < 0.6 * self.count {
            learned.without = learned.without.saturating_add(1);
            if (twist - *level) * sign > 0.0 || learned.without > 1 {
                let more = 0.08 * half_width * f32::from(learned.without.min(5));
                *level = twist + sign * more.max(self.count);
            }
            learned.travel = 0.0;
        } else {
            (learned.without, *kicks) = (0, 0);
            if learned.travel > 0.0 && (twist - learned.peak).abs() > 0.02 * half_width {
                let secant = (moved - learned.travel) / ((twist - learned.peak) * sign);
                learned.per_twist = (0.5 * (learned.per_twist + secant)).clamp(0.3, 3.0);
            }
            (learned.peak, learned.travel) = (twist, moved);
            if learned.least <= 0.0 || moved < learned.least {
                learned.least = moved;
            } else if moved < 2.0 * learned.least {
                learned.least += 0.1 * (moved - learned.least);
            }
            let begins = twist - sign * moved / learned.per_twist;
            if !levels.is_seen[forward] || (begins - *level) * sign < 0.0 {
                levels.is_seen[forward] = true;
                *level += 0.5 * (begins - *level);
            }
            levels.order();
        }
    }

    /// Learns the motor's inertia from impulse and speed, and its friction and the gain of its
    /// travel from how far it went.
    fn learn_motor(
        &self,
        memory: &mut MemoryState,
        bump: &BumpState,
        forward: usize,
        sample_time: f32,
    ) {
        let MotorModel { inertia, friction, .. } = &mut memory.motor;
        let gain = &mut memory.learned[forward].gain;
        let most = 1.5 * self.inertia;
        if bump.speed > 4.0 * self.motor_count / sample_time {
            let found = (bump.impulse / bump.speed).max(0.5 * *inertia).min(2.0 * *inertia);
            *inertia = (*inertia + 0.5 * (found - *inertia)).max(0.03 * self.inertia).min(most);
        }
        let wanted = bump.way.abs();
        let peak = bump.peak.max(0.0);
        let [low, high] = self.breakaway;
        if peak < (0.3 * wanted).max(2.0 * self.motor_count) {
            *friction = (1.25 * *friction).min(high);
            *inertia = (1.2 * *inertia).min(most);
            return;
        }
        let share = wanted / peak;
        if share < 0.75 {
            *friction = (0.85 * *friction).max(0.3 * low);
        }
        *gain *= 1.0 + 0.7 * (share.clamp(0.5, 1.6) - 1.0);
        if *gain > 2.0 {
            *gain *= 0.8;
            *inertia = (1.25 * *inertia).min(most);
        }
        *gain = gain.clamp(0.3, 2.5);
    }
}

impl MemoryState {
    /// Moves the origins. In the memory, only the twists depend on them.
    pub fn rebase(&mut self, twist: f32) {
        self.learned.iter_mut().for_each(|learned| learned.peak += twist);
    }
}
