//! Work that is shared by the threads of the caller's pool.
//!
//! Every function returns the same values for any number of threads: each item is worked on by itself, and results come
//! in the order of the items. The library makes no pool. It uses the one that the caller has entered by
//! `rayon::ThreadPool::install`, or else rayon's own, which has a thread for each core and is made when first needed.
//! If no thread can be made, as in most browsers, rayon works on the caller's thread alone.

use core::cell::Cell;
use core::time::Duration;

use rayon::prelude::*;

/// Amount of work from which on it is shared. To make the threads of a pool takes about 300 µs, and to wake them 10 to
/// 50 µs.
const MIN_SHARED: Duration = Duration::from_micros(500);
/// Number of chunks of work for each thread: threads that have finished theirs take over those of others.
const CHUNKS_PER_THREAD: usize = 8;

thread_local! {
    /// `true` while this thread shares no work.
    static ALONE: Cell<bool> = const { Cell::new(false) };
}

/// Does the work without sharing it: for callers that have work for each thread, and for processes that were forked, in
/// which the threads of rayon's own pool do not run.
pub fn alone<T>(work: impl FnOnce() -> T) -> T {
    /// Ends being alone, also if the work panics.
    struct Restore(bool);
    impl Drop for Restore {
        fn drop(&mut self) {
            ALONE.set(self.0);
        }
    }
    let _restore = Restore(ALONE.replace(true));
    work()
}

/// Returns the time that `count` items of work take, each of which takes about `each`.
pub fn total_time(count: usize, each: Duration) -> Duration {
    each.saturating_mul(u32::try_from(count).unwrap_or(u32::MAX))
}

/// Returns the number of threads that share work, with the caller's.
pub fn threads() -> usize {
    if ALONE.get() {
        1
    } else {
        rayon::current_num_threads()
    }
}

/// Returns `true` if there are threads to share with, and `count` items of work, each of which takes about `each`, are
/// worth sharing. A pool is made only if they are.
pub fn is_shared(count: usize, each: Duration) -> bool {
    count > 1 && total_time(count, each) >= MIN_SHARED && threads() > 1
}

/// Returns what `work` makes of each item, in order. `each` is about the time that an item takes.
pub fn map<T: Sync, R: Send>(items: &[T], each: Duration, work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    map_with(items, each, || (), |(), item| work(item))
}

/// Returns what `work` makes of each item, in order. Each thread has a workspace of its own, which must not change what
/// is returned. `each` is about the time that an item takes.
pub fn map_with<S, T: Sync, R: Send>(
    items: &[T],
    each: Duration,
    workspace: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, &T) -> R + Sync,
) -> Vec<R> {
    let all = |items: &[T]| -> Vec<R> {
        let mut workspace = workspace();
        let results = items.iter().map(|item| work(&mut workspace, item));
        results.collect()
    };
    if !is_shared(items.len(), each) {
        return all(items);
    }
    let chunks: Vec<Vec<R>> = items.par_chunks(chunk(items.len())).map(all).collect();
    chunks.into_iter().flatten().collect()
}

/// Replaces `results` by what `work` makes of each index below `count`. `each` is about the time that an index takes.
/// Allocates only if there are threads to share with, or there is no room yet.
pub fn collect<R: Send>(
    results: &mut Vec<R>,
    count: usize,
    each: Duration,
    work: impl Fn(usize) -> R + Sync,
) {
    if is_shared(count, each) {
        let indices = (0..count).into_par_iter().with_min_len(chunk(count));
        indices.map(&work).collect_into_vec(results);
    } else {
        results.clear();
        results.extend((0..count).map(work));
    }
}

/// Returns `true` if `holds` returns `true` for each index below `count`. `each` is about the time that an index takes.
pub fn all(count: usize, each: Duration, holds: impl Fn(usize) -> bool + Sync) -> bool {
    if is_shared(count, each) {
        (0..count).into_par_iter().all(&holds)
    } else {
        (0..count).all(holds)
    }
}

/// Returns what `work` makes of each item, in order, or `None` if it makes `None` of one. `each` is about the time that an
/// item takes.
pub fn try_map_mut<T: Send, R: Send>(
    items: &mut [T],
    each: Duration,
    work: impl Fn(&mut T) -> Option<R> + Sync,
) -> Option<Vec<R>> {
    if is_shared(items.len(), each) {
        items.par_iter_mut().map(&work).collect()
    } else {
        items.iter_mut().map(work).collect()
    }
}

/// Lets `work` change each item, of which it gets the index too. `each` is about the time that an item takes.
pub fn change<R: Send>(items: &mut [R], each: Duration, work: impl Fn(usize, &mut R) + Sync) {
    if is_shared(items.len(), each) {
        let chunk = chunk(items.len());
        let items = items.par_iter_mut().with_min_len(chunk).enumerate();
        items.for_each(|(index, item)| work(index, item));
    } else {
        for (index, item) in items.iter_mut().enumerate() {
            work(index, item);
        }
    }
}

/// Returns the number of items in a chunk.
fn chunk(count: usize) -> usize {
    count
        .div_ceil(CHUNKS_PER_THREAD * rayon::current_num_threads())
        .max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_for_any_number_of_threads() {
        let items: Vec<u64> = (0..1001).collect();
        let squares: Vec<u64> = items.iter().map(|k| k * k).collect();
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            for each in [Duration::ZERO, Duration::from_millis(1)] {
                pool.install(|| {
                    let shared = threads > 1 && each > Duration::ZERO;
                    assert_eq!(is_shared(items.len(), each), shared);
                    assert_eq!(map(&items, each, |k| k * k), squares);
                    let mut results = vec![7];
                    collect(&mut results, items.len(), each, |k| items[k]);
                    assert_eq!(results, items);
                    change(&mut results, each, |index, item| *item *= items[index]);
                    assert_eq!(results, squares);
                    let next = |k: &mut u64| k.checked_add(1);
                    let nexts = try_map_mut(&mut results, each, next);
                    assert_eq!(nexts.map(|nexts| nexts[1000]), Some(1_000_001));
                    results[500] = u64::MAX;
                    assert_eq!(try_map_mut(&mut results, each, next), None);
                    assert!(all(items.len(), each, |k| k < 1001));
                    assert!(!all(items.len(), each, |k| k != 777));
                });
            }
            assert!(map(&[0; 0], Duration::MAX, |k| *k).is_empty());
        }
    }

    #[test]
    fn who_is_alone_shares_nothing() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2);
        pool.build().unwrap().install(|| {
            let each = Duration::from_millis(1);
            assert!(alone(|| !is_shared(9, each)));
            assert!(is_shared(9, each));
            let panicked = std::panic::catch_unwind(|| alone(|| panic!("as it should")));
            assert!(panicked.is_err() && is_shared(9, each));
        });
    }

    #[test]
    fn a_workspace_belongs_to_one_thread_at_a_time() {
        let items = [1_u32; 1000];
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3);
        let counts = pool.build().unwrap().install(|| {
            let next = |count: &mut u32, one: &u32| {
                *count += one;
                *count
            };
            map_with(&items, Duration::from_millis(1), || 0, next)
        });
        // Each chunk counts from 1, and is no longer than its share.
        assert!(counts.iter().all(|count| (1..=42).contains(count)));
        assert_eq!(counts.iter().filter(|count| **count == 1).count(), 24);
    }
}
