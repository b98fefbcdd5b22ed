//! Numbers of threads.

use populace_device::{Backend as _, Schedule};
use populace_native::{MAX_THREADS, NativeBackend};

#[test]
fn more_threads_than_the_limit_are_refused() {
    for threads in [MAX_THREADS + 1, 1_000_000, usize::MAX] {
        let refused = NativeBackend::new(threads, Schedule::Fused).err();
        let words = refused.map(|error| error.to_string()).unwrap_or_default();
        let wanted = format!("{threads} threads, for at most 1024");
        assert!(words.contains(&wanted) && words.contains("0 for one per core"), "{words}");
    }
    let backend = NativeBackend::new(3, Schedule::Fused);
    assert!(backend.is_ok_and(|b| b.thread_count() == 3 && b.schedule() == Schedule::Fused));
}
