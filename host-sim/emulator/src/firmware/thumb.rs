//! Decodes as much of the Thumb-2 instruction set as is needed to follow calls, returns and the
//! stack pointer.
//!
//! Encodings: ARMv7-M Architecture Reference Manual (ARM DDI 0403), sections A5.2, A5.3 and A7.7.

/// Effect of an instruction on the flow of control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlFlow {
    /// Continues with the next instruction, or within the same function by a jump table.
    On,
    /// `bl`: calls the function at this address.
    Call(u32),
    /// `b` in any form: jumps to this address, with or without a condition.
    Branch(u32),
    /// `blx` of a register: calls a function whose address is known only at run time.
    CallRegister,
    /// `bx`, `mov` or `ldr` into the program counter, from anywhere but the link register.
    JumpRegister,
    /// Returns to the caller.
    Return,
}

/// Effect of an instruction on the stack pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stack {
    /// Reserves no stack; it may release some.
    Kept,
    /// Reserves this number of bytes.
    Takes(u32),
    /// Reserves a number of bytes that is in a register.
    Unknown,
}

/// One instruction of the machine code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// Size, bytes.
    pub size: u32,
    /// Effect on the flow of control.
    pub flow: ControlFlow,
    /// Effect on the stack pointer.
    pub stack: Stack,
}

impl Instruction {
    /// Decodes the instruction at `address` that begins with `first`. `second` is used only for a
    /// long instruction.
    pub fn decode(address: u32, first: u16, second: u16) -> Self {
        // Prefixes 0b11101, 0b11110 and 0b11111 begin an instruction of two halfwords.
        if first < 0xE800 {
            let first = u32::from(first);
            Self { size: 2, flow: short_flow(address, first), stack: short_stack(first) }
        } else {
            let (first, second) = (u32::from(first), u32::from(second));
            Self {
                size: 4,
                flow: long_flow(address, first, second),
                stack: long_stack(first, second),
            }
        }
    }
}

/// Returns an address relative to the program counter, which is four bytes ahead of the
/// instruction.
const fn relative(address: u32, offset: u32, bits: u32) -> u32 {
    let shift = 32 - bits;
    let signed = ((offset << shift) as i32) >> shift;
    address.wrapping_add(4).wrapping_add_signed(signed)
}

fn short_flow(address: u32, code: u32) -> ControlFlow {
    match code {
        0x4770 => ControlFlow::Return,
        // mov pc, lr
        0x46F7 => ControlFlow::Return,
        _ if code & 0xFF87 == 0x4700 => ControlFlow::JumpRegister,
        _ if code & 0xFF87 == 0x4780 => ControlFlow::CallRegister,
        // mov pc, rm and add pc, rm
        _ if code & 0xFF87 == 0x4687 || code & 0xFF87 == 0x4487 => ControlFlow::JumpRegister,
        // pop {..., pc}
        _ if code & 0xFF00 == 0xBD00 => ControlFlow::Return,
        // b<c>; conditions 14 and 15 are udf and svc.
        _ if code & 0xF000 == 0xD000 && code & 0x0F00 < 0x0E00 => {
            ControlFlow::Branch(relative(address, (code & 0xFF) << 1, 9))
        }
        _ if code & 0xF800 == 0xE000 => {
            ControlFlow::Branch(relative(address, (code & 0x7FF) << 1, 12))
        }
        // cbz and cbnz reach 126 bytes ahead.
        _ if code & 0xF500 == 0xB100 => ControlFlow::Branch(relative(
            address,
            (code >> 3 & 0x1F) << 1 | (code >> 9 & 1) << 6,
            32,
        )),
        _ => ControlFlow::On,
    }
}

fn short_stack(code: u32) -> Stack {
    match code {
        // push
        _ if code & 0xFE00 == 0xB400 => Stack::Takes(4 * (code & 0x1FF).count_ones()),
        // sub sp, #
        _ if code & 0xFF80 == 0xB080 => Stack::Takes(4 * (code & 0x7F)),
        // mov sp, r7: back to where the frame pointer is.
        0x46BD => Stack::Kept,
        // mov sp, rm and add sp, rm
        _ if code & 0xFF87 == 0x4685 || code & 0xFF87 == 0x4485 => Stack::Unknown,
        _ => Stack::Kept,
    }
}

fn long_flow(address: u32, first: u32, second: u32) -> ControlFlow {
    let sign = first >> 10 & 1;
    if first & 0xF800 == 0xF000 && second & 0x8000 != 0 {
        let (j1, j2) = (second >> 13 & 1, second >> 11 & 1);
        let low = (second & 0x7FF) << 1;
        if second & 0x1000 != 0 {
            // bl and b.w: I = not (J xor S)
            let (i1, i2) = (1 ^ j1 ^ sign, 1 ^ j2 ^ sign);
            let offset = sign << 24 | i1 << 23 | i2 << 22 | (first & 0x3FF) << 12 | low;
            let target = relative(address, offset, 25);
            return if second & 0x4000 != 0 {
                ControlFlow::Call(target)
            } else {
                ControlFlow::Branch(target)
            };
        }
        // b<c>.w; conditions 14 and 15 are barriers, msr and their like.
        if second & 0x4000 == 0 && first >> 6 & 0xF < 14 {
            let offset = sign << 20 | j2 << 19 | j1 << 18 | (first & 0x3F) << 12 | low;
            return ControlFlow::Branch(relative(address, offset, 21));
        }
        return ControlFlow::On;
    }
    match (first, second) {
        // ldr pc, [sp], #4: a pop of one register
        (0xF85D, 0xFB04) => ControlFlow::Return,
        // pop.w {..., pc}
        (0xE8BD, _) if second & 0x8000 != 0 => ControlFlow::Return,
        // ldr pc, any form
        _ if first & 0xFF70 == 0xF850 && second >> 12 == 15 => ControlFlow::JumpRegister,
        // ldm with the program counter among the registers
        _ if (first & 0xFFD0 == 0xE890 || first & 0xFFD0 == 0xE910) && second & 0x8000 != 0 => {
            ControlFlow::JumpRegister
        }
        _ => ControlFlow::On,
    }
}

fn long_stack(first: u32, second: u32) -> Stack {
    let destination_is_sp = second & 0x0F00 == 0x0D00;
    match first {
        // push.w
        0xE92D => Stack::Takes(4 * second.count_ones()),
        // str rt, [sp, #-imm8]!, which is also the push of one register
        0xF84D if second & 0x0F00 == 0x0D00 => Stack::Takes(second & 0xFF),
        // strd rt, rt2, [sp, #-4 imm8]!
        0xE96D => Stack::Takes(4 * (second & 0xFF)),
        // vpush
        0xED2D | 0xED6D if second & 0x0E00 == 0x0A00 => Stack::Takes(4 * (second & 0xFF)),
        // sub.w sp, sp, #, with a constant of A5.3.2; subw sp, sp, #imm12
        0xF1AD | 0xF5AD if destination_is_sp => Stack::Takes(expand(first, second)),
        0xF2AD | 0xF6AD if destination_is_sp => Stack::Takes(immediate(first, second)),
        // sub.w sp, sp, rm
        0xEBAD if destination_is_sp => Stack::Unknown,
        _ => Stack::Kept,
    }
}

/// Returns the constant `i:imm3:imm8`.
const fn immediate(first: u32, second: u32) -> u32 {
    (first >> 10 & 1) << 11 | (second >> 12 & 7) << 8 | second & 0xFF
}

/// Returns the constant by `ThumbExpandImm` of A5.3.2.
const fn expand(first: u32, second: u32) -> u32 {
    let coded = immediate(first, second);
    let byte = coded & 0xFF;
    match coded >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte << 24 | byte << 16 | byte << 8 | byte,
        _ => (0x80 | byte & 0x7F).rotate_right(coded >> 7),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(address: u32, code: u32) -> Instruction {
        let long = code > 0xFFFF;
        let (first, second) = if long { (code >> 16, code & 0xFFFF) } else { (code, 0) };
        Instruction::decode(address, first as u16, second as u16)
    }

    // Expected values: llvm-objdump and the manual's tables.
    #[test]
    fn calls_branches_and_returns_lead_where_the_disassembler_says() {
        assert_eq!(at(0x0800_358a, 0xE7FE).flow, ControlFlow::Branch(0x0800_358a));
        assert_eq!(at(0x0800_058a, 0xD113).flow, ControlFlow::Branch(0x0800_05b4));
        assert_eq!(at(0x0800_05b2, 0xE00E).flow, ControlFlow::Branch(0x0800_05d2));
        assert_eq!(at(0x0800_0000, 0xF7FF_FFFE).flow, ControlFlow::Call(0x0800_0000));
        assert_eq!(at(0x0800_0000, 0xF000_F800).flow, ControlFlow::Call(0x0800_0004));
        assert_eq!(at(0x0800_0000, 0xF000_B800).flow, ControlFlow::Branch(0x0800_0004));
        assert_eq!(at(0x0800_0000, 0xF43F_AFFE).flow, ControlFlow::Branch(0x0800_0000)); // beq.w to itself
        assert_eq!(at(0, 0xB108).flow, ControlFlow::Branch(6)); // cbz r0, 6
        for code in [0x4770, 0xBDF0, 0xE8BD_8FF0, 0xF85D_FB04] {
            assert_eq!(at(0, code).flow, ControlFlow::Return, "{code:#x}");
        }
        for (code, flow) in [
            (0x4718, ControlFlow::JumpRegister),
            (0x4790, ControlFlow::CallRegister),
            (0x46F7, ControlFlow::Return),
        ] {
            assert_eq!(at(0, code).flow, flow, "{code:#x}");
        }
    }

    #[test]
    fn what_looks_like_a_branch_is_none() {
        // nop; svc 0; udf 0; dsb sy; msr basepri, r0; pop {r4}; tbb [pc, r0]; pld [r0]
        for code in
            [0xBF00, 0xDF00, 0xDE00, 0xF3BF_8F4F, 0xF380_8811, 0xBC10, 0xE8DF_F000, 0xF890_F000]
        {
            assert_eq!(at(0, code).flow, ControlFlow::On, "{code:#x}");
        }
    }

    #[test]
    fn room_on_the_stack_is_counted_in_bytes() {
        let takes = [
            (0xB5F0, 20),         // push {r4-r7, lr}
            (0xE92D_0F00, 16),    // push.w {r8-r11}
            (0xB081, 4),          // sub sp, #4
            (0xB0AC, 0xB0),       // sub sp, #0xb0
            (0xED2D_8B10, 64),    // vpush {d8-d15}
            (0xF84D_BD04, 4),     // str r11, [sp, #-4]!
            (0xF5AD_6D80, 0x400), // sub.w sp, sp, #0x400
            (0xF2AD_4D0C, 0x40C), // subw sp, sp, #0x40c
        ];
        for (code, bytes) in takes {
            assert_eq!(at(0, code).stack, Stack::Takes(bytes), "{code:#x}");
        }
        assert_eq!(at(0, 0xEBAD_0D00).stack, Stack::Unknown); // sub.w sp, sp, r0
        assert_eq!(at(0, 0xB001).stack, Stack::Kept); // add sp, #4
        assert_eq!(at(0, 0xF1A7_0D18).stack, Stack::Kept); // sub.w sp, r7, #0x18
    }
}
