//! Copies of whole words, eight at a time.
//!
//! The compiler calls these functions for a copy of more than a few words whose ends are aligned: a
//! tick into the static that is published and into the queue to the log (100 and 116 bytes), a
//! motion into the servo. The versions in its own library move one word after the other, with an
//! address for each: about 100 instructions for a tick, where these take 40
//! (tests/evidence/cost.md). The names and the registers of the arguments are those of the ARM
//! run-time ABI (IHI 0043, 4.3.4): destination `r0`, source `r1`, bytes `r2`; `r0` to `r3` and
//! `r12` are free to use.

use core::arch::global_asm;

global_asm!(
    ".syntax unified",
    ".pushsection .text.__aeabi_memcpy4, \"ax\", %progbits",
    ".global __aeabi_memcpy4",
    ".global __aeabi_memcpy8",
    ".type __aeabi_memcpy4, %function",
    ".type __aeabi_memcpy8, %function",
    ".p2align 2",
    ".thumb_func",
    "__aeabi_memcpy4:",
    ".thumb_func",
    "__aeabi_memcpy8:",
    "    subs    r2, #32",
    "    blo     2f",
    "    push    {{r4, r5, r6, r7, r8, r9, r10}}",
    // Eight words.
    "1:  ldm     r1!, {{r3, r4, r5, r6, r7, r8, r9, r10}}",
    "    stm     r0!, {{r3, r4, r5, r6, r7, r8, r9, r10}}",
    "    subs    r2, #32",
    "    bhs     1b",
    "    pop     {{r4, r5, r6, r7, r8, r9, r10}}",
    // Less than 32 bytes are left.
    "2:  adds    r2, #28",
    "    blo     4f",
    // One word.
    "3:  ldr     r3, [r1], #4",
    "    str     r3, [r0], #4",
    "    subs    r2, #4",
    "    bhs     3b",
    // Less than four bytes are left.
    "4:  adds    r2, #4",
    "    it      eq",
    "    bxeq    lr",
    "5:  ldrb    r3, [r1], #1",
    "    strb    r3, [r0], #1",
    "    subs    r2, #1",
    "    bne     5b",
    "    bx      lr",
    ".size __aeabi_memcpy4, . - __aeabi_memcpy4",
    ".size __aeabi_memcpy8, . - __aeabi_memcpy8",
    ".popsection",
);
