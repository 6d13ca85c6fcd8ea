//! Pointers from C. All that is read or written behind one passes through here.

use crate::status::Status;

/// What is behind a pointer, to read.
///
/// # Safety
/// If it is neither null nor misaligned, it points to a `T` that nobody writes during `'a`.
pub(crate) unsafe fn read<'a, T>(pointer: *const T) -> Result<&'a T, Status> {
    check(pointer)?;
    // SAFETY: the caller's promise.
    Ok(unsafe { &*pointer })
}

/// Writes a result.
///
/// # Safety
/// If it is neither null nor misaligned, it points to memory for a `T` that nobody else uses.
pub(crate) unsafe fn write<T>(pointer: *mut T, value: T) -> Result<(), Status> {
    check(pointer)?;
    // SAFETY: the caller's promise.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Elements of an array; none if `count` is 0, also behind a null pointer.
///
/// # Safety
/// If it is neither null nor misaligned, it points to `count` elements that nobody writes during `'a`.
pub(crate) unsafe fn array<'a, T>(pointer: *const T, count: usize) -> Result<&'a [T], Status> {
    if count == 0 {
        return Ok(&[]);
    }
    check(pointer)?;
    let bytes = count.checked_mul(size_of::<T>());
    if bytes.is_none_or(|bytes| isize::try_from(bytes).is_err()) {
        return Err(Status::ErrorTooLarge);
    }
    // SAFETY: the caller's promise.
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}

/// Neither null nor misaligned.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), Status> {
    if pointer.is_null() {
        Err(Status::ErrorNull)
    } else if !pointer.is_aligned() {
        Err(Status::ErrorMisaligned)
    } else {
        Ok(())
    }
}

/// A struct that begins with its own size, by which header and library are compared.
///
/// # Safety
/// The first field of the struct is the size, a `u32`.
pub(crate) unsafe trait Sized32 {}

/// Writes a result over a struct whose caller has set its size.
///
/// # Safety
/// As [`write`]'s; the size can be read.
pub(crate) unsafe fn write_sized<T: Sized32>(pointer: *mut T, value: T) -> Result<(), Status> {
    check(pointer)?;
    // SAFETY: the caller's promise, and the trait's.
    let size = unsafe { pointer.cast::<u32>().read() };
    if usize::try_from(size) != Ok(size_of::<T>()) {
        return Err(Status::ErrorStructSize);
    }
    // SAFETY: the caller's promise.
    unsafe { pointer.write(value) };
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn null_misaligned_and_endless_arrays_are_refused() {
        let numbers = [1_u32, 2, 3];
        let odd = numbers.as_ptr().wrapping_byte_add(1);
        // SAFETY: only valid pointers are followed.
        unsafe {
            assert_eq!(read::<u32>(core::ptr::null()), Err(Status::ErrorNull));
            assert_eq!(read(odd), Err(Status::ErrorMisaligned));
            assert_eq!(read(numbers.as_ptr()), Ok(&1));
            assert_eq!(array(numbers.as_ptr(), 3), Ok(&numbers[..]));
            assert_eq!(array::<u32>(core::ptr::null(), 0), Ok(&[][..]));
            assert_eq!(array::<u32>(core::ptr::null(), 1), Err(Status::ErrorNull));
            let endless = array(numbers.as_ptr(), usize::MAX / 4);
            assert_eq!(endless, Err(Status::ErrorTooLarge));
        }
    }
}
