//! Readers of other crates that end in a panic on a malformed file: the file is refused, the program goes on.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use super::{Error, ErrorKind, Result};

thread_local! {
    /// Whether this thread is inside a reader.
    static READS: Cell<bool> = const { Cell::new(false) };
}

/// Runs a reader of files in this format; a panic in it is a refusal of the file, and nothing is printed of it.
///
/// # Errors
/// Those of the reader.
pub(crate) fn guarded<T>(format: &str, read: impl FnOnce() -> Result<T>) -> Result<T> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let loud = take_hook();
        set_hook(Box::new(move |panic| {
            if !READS.get() {
                loud(panic);
            }
        }));
    });
    let outer = READS.replace(true);
    let read = catch_unwind(AssertUnwindSafe(read));
    READS.set(outer);
    read.unwrap_or_else(|_| {
        Err(Error::new(ErrorKind::Syntax)
            .found("data that its reader cannot handle")
            .expected(format!("a sound {format}"))
            .remedy("the file is damaged: export or copy it again"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_a_panic_of_a_reader_is_a_refusal() {
        let empty: Vec<u8> = Vec::new();
        let error = guarded("table", || Ok(empty[std::hint::black_box(3)])).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Syntax);
        assert!(error.to_string().contains("a sound table"), "{error}");
        assert_eq!(guarded("table", || Ok(3)).unwrap(), 3);
        assert!(!READS.get());
    }
}
