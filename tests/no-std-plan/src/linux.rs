//! The kernel, called without a C library; and the four functions over memory
//! that compilers take for granted. All of this program's unsafe code.

use core::arch::{asm, global_asm};

#[cfg(not(all(target_arch = "x86_64", target_os = "linux")))]
compile_error!("this program is written for x86-64 Linux");

const READ: usize = 0;
const WRITE: usize = 1;
const EXIT: usize = 60;

// The kernel starts a program with its arguments on the stack and no return
// address; functions expect the stack at a multiple of 16.
global_asm!(
    ".globl _start",
    "_start:",
    "xor ebp, ebp",
    "and rsp, -16",
    "call program",
    "ud2",
);

// In assembly, since a compiler may turn a loop that copies into a call of memcpy.
// System V: rdi, rsi, rdx in, rax out; the direction flag is clear on entry.
global_asm!(
    ".globl memcpy, memmove, memset, memcmp, bcmp",
    "memmove:",
    "mov rax, rdi",
    "sub rax, rsi",
    "cmp rax, rdx",
    "jae memcpy", // The end of the source is not in the destination.
    "mov rax, rdi",
    "mov rcx, rdx",
    "lea rdi, [rdi + rdx - 1]",
    "lea rsi, [rsi + rdx - 1]",
    "std",
    "rep movsb",
    "cld",
    "ret",
    "memcpy:",
    "mov rax, rdi",
    "mov rcx, rdx",
    "rep movsb",
    "ret",
    "memset:",
    "mov r8, rdi",
    "mov eax, esi",
    "mov rcx, rdx",
    "rep stosb",
    "mov rax, r8",
    "ret",
    "bcmp:",
    "memcmp:",
    "xor eax, eax",
    "mov rcx, rdx",
    "cmp rcx, rcx", // Equal, if there is nothing to compare.
    "repe cmpsb",
    "je 2f",
    "movzx eax, byte ptr [rdi - 1]",
    "movzx ecx, byte ptr [rsi - 1]",
    "sub eax, ecx",
    "2:",
    "ret",
);

/// Reads what is there, at most what fits; `None` at the end or on an error.
pub fn read(room: &mut [u8]) -> Option<usize> {
    // SAFETY: the kernel writes at most `room.len()` bytes to `room`, which is
    // ours alone while it is borrowed.
    let read = unsafe { call(READ, 0, room.as_mut_ptr() as usize, room.len()) };
    usize::try_from(read).ok().filter(|read| *read > 0)
}

/// Writes to standard output; what cannot be written is lost.
pub fn write(bytes: &[u8]) {
    // SAFETY: the kernel only reads these bytes.
    unsafe { call(WRITE, 1, bytes.as_ptr() as usize, bytes.len()) };
}

/// Ends the process.
pub fn exit(code: i32) -> ! {
    loop {
        // SAFETY: ends the process; touches no memory of ours.
        unsafe { call(EXIT, code as usize, 0, 0) };
    }
}

/// # Safety
/// The kernel does with these arguments what its manual says.
unsafe fn call(number: usize, first: usize, second: usize, third: usize) -> isize {
    let result: isize;
    // SAFETY: the kernel changes these three registers, and the memory that the
    // caller answers for.
    unsafe {
        asm!(
            "syscall",
            inlateout("rax") number => result,
            in("rdi") first,
            in("rsi") second,
            in("rdx") third,
            lateout("rcx") _,
            lateout("r11") _,
            options(nostack),
        );
    }
    result
}
