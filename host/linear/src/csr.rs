//! Compressed sparse rows (CSR): a list of lists in two arrays.

use core::borrow::Borrow;
use core::ops::{Index, IndexMut, Range};

/// Compressed rows: lists of any lengths, stored one behind the other in one array, with the end of each list in a
/// second array.
#[derive(Clone, Debug, PartialEq)]
pub struct Csr<T> {
    items: Vec<T>,
    ends: Vec<u32>,
}

impl<T> Default for Csr<T> {
    fn default() -> Self {
        Self {
            items: Vec::new(),
            ends: Vec::new(),
        }
    }
}

impl<T> Csr<T> {
    /// Returns no list, with room for `lists` lists and for `items` items in all of them.
    #[must_use]
    pub fn with_capacity(lists: usize, items: usize) -> Self {
        Self {
            items: Vec::with_capacity(items),
            ends: Vec::with_capacity(lists),
        }
    }

    /// Adds a list at the end.
    ///
    /// # Panics
    /// If there are 2³² items or more in all.
    pub fn push(&mut self, list: impl IntoIterator<Item = T>) {
        self.items.extend(list);
        let end = u32::try_from(self.items.len());
        self.ends.push(end.expect("fewer than 2^32 items"));
    }

    /// Sorts each list.
    pub fn sort_each(&mut self)
    where
        T: Ord,
    {
        let mut rest = &mut self.items[..];
        let mut start = 0;
        for &end in &self.ends {
            let (list, behind) = rest.split_at_mut((end - start) as usize);
            list.sort_unstable();
            (rest, start) = (behind, end);
        }
    }

    /// Removes all lists and keeps the memory.
    pub fn clear(&mut self) {
        self.items.clear();
        self.ends.clear();
    }

    /// Returns the number of lists.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Returns `true` if there is no list.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Returns the lists in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[T]> + Clone {
        (0..self.len()).map(|list| &self[list])
    }

    /// Replaces each item by its `image`. The lists keep their lengths.
    pub fn map<U>(self, image: impl FnMut(T) -> U) -> Csr<U> {
        Csr {
            items: self.items.into_iter().map(image).collect(),
            ends: self.ends,
        }
    }

    /// Returns all items, list after list.
    #[must_use]
    pub fn items(&self) -> &[T] {
        &self.items
    }

    /// Returns for each list the position behind its last item in [`items`](Self::items).
    #[must_use]
    pub fn ends(&self) -> &[u32] {
        &self.ends
    }
}

impl<T> Csr<T> {
    /// Returns the positions of the items of a list in [`items`](Self::items).
    #[must_use]
    pub fn range(&self, list: usize) -> Range<usize> {
        let start = list.checked_sub(1).map_or(0, |before| self.ends[before]);
        start as usize..self.ends[list] as usize
    }
}

impl<T> Index<usize> for Csr<T> {
    type Output = [T];

    fn index(&self, list: usize) -> &[T] {
        &self.items[self.range(list)]
    }
}

impl<T> IndexMut<usize> for Csr<T> {
    fn index_mut(&mut self, list: usize) -> &mut [T] {
        let range = self.range(list);
        &mut self.items[range]
    }
}

impl<T, L: IntoIterator<Item = T>> FromIterator<L> for Csr<T> {
    fn from_iter<I: IntoIterator<Item = L>>(lists: I) -> Self {
        let mut rows = Self::default();
        for list in lists {
            rows.push(list);
        }
        rows
    }
}

/// Inverts a relation: lists, for each of `count` keys, the values paired with it, in the given order. Iterates over
/// the pairs twice.
///
/// # Panics
/// If a key is not below `count`.
pub fn group_by_key<T: Copy + Default, P: Borrow<(usize, T)>>(
    count: usize,
    pairs: impl IntoIterator<Item = P> + Clone,
) -> Csr<T> {
    let mut ends = vec![0_u32; count];
    let mut total = 0;
    for pair in pairs.clone() {
        ends[pair.borrow().0] += 1;
        total += 1;
    }
    let mut items = vec![T::default(); total];
    let mut start = 0;
    for end in &mut ends {
        let size = *end;
        *end = start;
        start += size;
    }
    for pair in pairs {
        let (key, value) = *pair.borrow();
        items[ends[key] as usize] = value;
        ends[key] += 1;
    }
    Csr { items, ends }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_changed_each_on_its_own() {
        let mut lists: Csr<i32> = [vec![1, 2], vec![], vec![3]].into_iter().collect();
        lists[0].reverse();
        lists[2][0] = 7;
        let lists = lists.map(|item| 10 * item);
        let lists: Vec<&[i32]> = lists.iter().collect();
        assert_eq!(lists, [&[20, 10][..], &[], &[70]]);
    }

    #[test]
    fn values_of_a_key_keep_their_order() {
        let pairs = [(2, 'a'), (0, 'b'), (2, 'c'), (0, 'd')];
        let grouped = group_by_key(4, &pairs);
        let lists: Vec<&[char]> = grouped.iter().collect();
        assert_eq!(lists, [&['b', 'd'][..], &[], &['a', 'c'], &[]]);
        assert_eq!(grouped, group_by_key(4, pairs.into_iter()));
    }
}
