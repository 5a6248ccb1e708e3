//! Cycles against the manual's tables.

use super::*;

fn of(code: u32) -> Result<Timing, UnknownTiming> {
    let (first, second) = if code > 0xFFFF { (code >> 16, code & 0xFFFF) } else { (code, 0) };
    Timing::of(first as u16, second as u16)
}

// Encodings: llvm-mc. Cycles: the manual's tables, N being the registers of a list, P left out.
#[test]
fn each_kind_of_instruction_takes_what_the_manual_says() {
    let table = [
        (1, 0x2001),       // movs r0, #1
        (1, 0x18D1),       // adds r1, r2, r3
        (1, 0xEB09_08CA),  // add.w r8, r9, r10, lsl #3
        (1, 0xF241_2134),  // movw r1, #4660
        (1, 0xF2C1_2134),  // movt r1, #4660
        (1, 0x2C07),       // cmp r4, #7
        (1, 0xF013_0F03),  // tst.w r3, #3
        (1, 0x4348),       // muls r0, r1, r0
        (1, 0xFB01_3002),  // mla r0, r1, r2, r3
        (1, 0xFBA2_0103),  // umull r0, r1, r2, r3
        (1, 0xFBC2_0103),  // smlal r0, r1, r2, r3
        (1, 0xFB51_F002),  // smmul r0, r1, r2
        (12, 0xFBB1_F0F2), // udiv r0, r1, r2
        (12, 0xFB91_F0F2), // sdiv r0, r1, r2
        (1, 0xFAB1_F081),  // clz r0, r1
        (1, 0xFA91_F0A1),  // rbit r0, r1
        (1, 0xB2C8),       // uxtb r0, r1
        (1, 0xFA0F_F889),  // sxth.w r8, r9
        (1, 0xF3C1_00C4),  // ubfx r0, r1, #3, #5
        (1, 0xF361_00C7),  // bfi r0, r1, #3, #5
        (1, 0xF301_0007),  // ssat r0, #8, r1
        (1, 0xFA82_F081),  // qadd r0, r1, r2
        (1, 0xFA81_F042),  // uadd8 r0, r1, r2
        (1, 0x4088),       // lsls r0, r1
        (1, 0xBA08),       // rev r0, r1
        (1, 0xA002),       // adr r0, #8
        (1, 0xB004),       // add sp, #16
        (1, 0xF2AD_4D00),  // subw sp, sp, #1024
        (2, 0x6848),       // ldr r0, [r1, #4]
        (2, 0xF851_0022),  // ldr.w r0, [r1, r2, lsl #2]
        (2, 0x7908),       // ldrb r0, [r1, #4]
        (2, 0xF931_0C04),  // ldrsh.w r0, [r1, #-4]
        (2, 0x9802),       // ldr r0, [sp, #8]
        (2, 0xF851_0B04),  // ldr r0, [r1], #4
        (3, 0x4802),       // ldr r0, [pc, #8]
        (3, 0xF8DF_8008),  // ldr.w r8, [pc, #8]
        (2, 0x6048),       // str r0, [r1, #4]
        (2, 0xF8A1_0190),  // strh.w r0, [r1, #400]
        (2, 0x5488),       // strb r0, [r1, r2]
        (3, 0xE9D2_0102),  // ldrd r0, r1, [r2, #8]
        (3, 0xE9CD_0102),  // strd r0, r1, [sp, #8]
        (2, 0xE851_0F00),  // ldrex r0, [r1]
        (2, 0xE841_0200),  // strex r2, r0, [r1]
        (2, 0xE8D1_0F4F),  // ldrexb r0, [r1]
        (4, 0xE890_000E),  // ldm r0, {r1, r2, r3}
        (5, 0xE880_010E),  // stm.w r0, {r1, r2, r3, r8}
        (3, 0xE920_0102),  // stmdb r0!, {r1, r8}
        (6, 0xB5F0),       // push {r4, r5, r6, r7, lr}
        (7, 0xE92D_41F0),  // push.w {r4, r5, r6, r7, r8, lr}
        (6, 0xBDF0),       // pop {r4, r5, r6, r7, pc}
        (7, 0xE8BD_81F0),  // pop.w {r4, r5, r6, r7, r8, pc}
        (2, 0xF84D_ED04),  // str lr, [sp, #-4]!
        (2, 0xF85D_FB04),  // ldr pc, [sp], #4
        (1, 0xE010),       // b #32
        (1, 0xD010),       // beq #32
        (1, 0xF000_8640),  // beq.w #3200
        (1, 0xF007_BE80),  // b.w #32000
        (1, 0xF007_FE80),  // bl #32000
        (1, 0x4770),       // bx lr
        (1, 0x4798),       // blx r3
        (1, 0xB120),       // cbz r0, #8
        (1, 0xBB0F),       // cbnz r7, #66
        (3, 0xE8DF_F000),  // tbb [pc, r0]
        (3, 0xE8DF_F010),  // tbh [pc, r0, lsl #1]
        (1, 0x468F),       // mov pc, r1
        (1, 0xBF00),       // nop
        (1, 0xF3AF_8000),  // nop.w
        (1, 0xBF40),       // sev
        (2, 0xB672),       // cpsid i
        (2, 0xB662),       // cpsie i
        (2, 0xF3EF_8010),  // mrs r0, primask
        (2, 0xF380_8811),  // msr basepri, r0
        (1, 0xF3BF_8F5F),  // dmb sy
        (1, 0xF3BF_8F4F),  // dsb sy
        (4, 0xF3BF_8F6F),  // isb sy
        (1, 0xF3BF_8F2F),  // clrex
        (1, 0xEE30_0A81),  // vadd.f32 s0, s1, s2
        (1, 0xEE30_0AC1),  // vsub.f32 s0, s1, s2
        (1, 0xEE20_0A81),  // vmul.f32 s0, s1, s2
        (1, 0xEE20_0AC1),  // vnmul.f32 s0, s1, s2
        (3, 0xEE00_0A81),  // vmla.f32 s0, s1, s2
        (3, 0xEE00_0AC1),  // vmls.f32 s0, s1, s2
        (3, 0xEE10_0AC1),  // vnmla.f32 s0, s1, s2
        (3, 0xEEA0_0A81),  // vfma.f32 s0, s1, s2
        (3, 0xEE90_0A81),  // vfnms.f32 s0, s1, s2
        (14, 0xEE80_0A81), // vdiv.f32 s0, s1, s2
        (14, 0xEEB1_0AE0), // vsqrt.f32 s0, s1
        (1, 0xEEB0_0AE0),  // vabs.f32 s0, s1
        (1, 0xEEB1_0A60),  // vneg.f32 s0, s1
        (1, 0xEEB0_0A60),  // vmov.f32 s0, s1
        (1, 0xEEB7_0A00),  // vmov.f32 s0, #1.0
        (1, 0xEEB4_0A60),  // vcmp.f32 s0, s1
        (1, 0xEEB5_0A40),  // vcmp.f32 s0, #0
        (1, 0xEEB8_0AE0),  // vcvt.f32.s32 s0, s1
        (1, 0xEEBC_0AE0),  // vcvt.u32.f32 s0, s1
        (1, 0xEEBD_0A60),  // vcvtr.s32.f32 s0, s1
        (1, 0xEEBA_0ACE),  // vcvt.f32.s32 s0, s0, #4
        (1, 0xEEB2_0A60),  // vcvtb.f32.f16 s0, s1
        (1, 0xEE10_0A90),  // vmov r0, s1
        (1, 0xEE00_0A90),  // vmov s1, r0
        (2, 0xEC51_0A11),  // vmov r0, r1, s2, s3
        (2, 0xEC41_0A11),  // vmov s2, s3, r0, r1
        (2, 0xEC51_0B11),  // vmov r0, r1, d1
        (1, 0xEE20_0B10),  // vmov.32 d0[1], r0
        (1, 0xEEF1_FA10),  // vmrs apsr_nzcv, fpscr
        (1, 0xEEE1_0A10),  // vmsr fpscr, r0
        (2, 0xED90_0A01),  // vldr s0, [r0, #4]
        (3, 0xED90_0B02),  // vldr d0, [r0, #8]
        (3, 0xED9F_0A02),  // vldr s0, [pc, #8]
        (2, 0xED80_0A01),  // vstr s0, [r0, #4]
        (3, 0xED80_0B02),  // vstr d0, [r0, #8]
        (5, 0xEC90_0A04),  // vldmia r0, {s0, s1, s2, s3}
        (5, 0xECA0_0B04),  // vstmia r0!, {d0, d1}
        (17, 0xED2D_8B10), // vpush {d8, d9, d10, d11, d12, d13, d14, d15}
        (3, 0xECBD_8B02),  // vpop {d8}
        (1, 0xBF0C),       // ite eq
    ];
    for (cycles, code) in table {
        assert_eq!(of(code).map(|timing| timing.cycles), Ok(cycles), "{code:#x}");
    }
}

#[test]
fn what_is_not_known_is_named_and_never_a_cycle() {
    let unknown = [
        0xBF30,      // wfi
        0xBF20,      // wfe
        0xDE00,      // udf #0
        0xF7F0_A000, // udf.w #0
        0xDF00,      // svc #0
        0xBE00,      // bkpt #0
        0xEE31_0B02, // vadd.f64 d0, d1, d2
        0xEEB1_0BC1, // vsqrt.f64 d0, d1
        0xEF22_0844, // vadd.i32 q0, q1, q2
        0xEE01_0E12, // mcr p14, #0, r0, c1, c2, #0
        0xF890_F000, // pld [r0]
    ];
    for code in unknown {
        assert!(of(code).is_err(), "{code:#x}");
    }
    assert_eq!(of(0xDE00).unwrap_err().to_string(), "the encoding de00");
    assert_eq!(of(0xEE31_0B02).unwrap_err().to_string(), "the encoding ee31 0b02");
}

#[test]
fn an_address_that_was_just_computed_costs_a_cycle() {
    let waits = |one: u32, next: u32| of(one).unwrap().holds_up(&of(next).unwrap());
    // adds r1, r2, r3 before ldr r0, [r1, #4]; before ldr.w r0, [r1, r2, lsl #2]; before strd r0,
    // r1, [sp, #8].
    assert_eq!(waits(0x18D1, 0x6848), 1);
    assert_eq!(waits(0x18D1, 0xF851_0022), 1);
    assert_eq!(waits(0x18D1, 0xE9CD_0102), 0);
    // add sp, #16 before ldr r0, [sp, #8]; lsls r0, r1 before strb r0, [r1, r2], whose value is not
    // an address.
    assert_eq!(waits(0xB004, 0x9802), 1);
    assert_eq!(waits(0x4088, 0x5488), 0);
    // What was loaded is not computed: ldr r0, [r1, #4] before ldr.w r8 and r0 of a list.
    assert_eq!(waits(0x6848, 0xE890_000E), 0);
}

#[test]
fn a_float_that_was_just_computed_costs_a_cycle() {
    let waits = |one: u32, next: u32| of(one).unwrap().holds_up(&of(next).unwrap());
    // vadd.f32 s0, s1, s2 before itself; before vabs.f32 s0, s1; before vmla.f32 s0, s1, s2, which
    // adds to s0.
    assert_eq!(waits(0xEE30_0A81, 0xEE30_0A81), 0);
    assert_eq!(waits(0xEE30_0A81, 0xEEB0_0AE0), 0);
    assert_eq!(waits(0xEE30_0A81, 0xEE00_0A81), 1);
    // Before vstr s0, [r0, #4]; vstr d0, [r0, #8]; vmov r0, s1; vcmp.f32 s0, #0.
    assert_eq!(waits(0xEE30_0A81, 0xED80_0A01), 1);
    assert_eq!(waits(0xEE30_0A81, 0xED80_0B02), 1);
    assert_eq!(waits(0xEE30_0A81, 0xEE10_0A90), 0);
    assert_eq!(waits(0xEE30_0A81, 0xEEB5_0A40), 1);
    // vcmp.f32 s0, s1 before vmrs; and before an integer instruction.
    assert_eq!(waits(0xEEB4_0A60, 0xEEF1_FA10), 1);
    assert_eq!(waits(0xEEB4_0A60, 0x18D1), 0);
}
