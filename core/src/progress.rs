/// What a call of `poll` has come to.
#[derive(Debug, Clone, Copy, PartialEq)]
#[must_use = "a task that is done must not be polled for ever"]
pub enum Progress<T> {
    /// One piece of work was done; more is left.
    Pending,
    /// The result.
    Done(T),
}
