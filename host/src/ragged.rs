//! A list of lists in two arrays.

use core::ops::Index;

/// Lists of differing lengths, one behind the other in one array.
#[derive(Clone, Debug, PartialEq)]
pub struct Ragged<T> {
    items: Vec<T>,
    ends: Vec<u32>,
}

impl<T> Default for Ragged<T> {
    fn default() -> Self {
        Self {
            items: Vec::new(),
            ends: Vec::new(),
        }
    }
}

impl<T> Ragged<T> {
    /// Adds a list at the end.
    ///
    /// # Panics
    /// Past 2³² items in all.
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

    /// Takes all lists away and keeps the memory.
    pub fn clear(&mut self) {
        self.items.clear();
        self.ends.clear();
    }

    /// Number of lists.
    #[must_use]
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is no list.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The lists in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &[T]> {
        (0..self.len()).map(|list| &self[list])
    }

    /// All items, list after list.
    #[must_use]
    pub fn items(&self) -> &[T] {
        &self.items
    }

    /// For each list, the position behind its last item.
    #[must_use]
    pub fn ends(&self) -> &[u32] {
        &self.ends
    }
}

impl<T> Index<usize> for Ragged<T> {
    type Output = [T];

    fn index(&self, list: usize) -> &[T] {
        let start = list.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.items[start as usize..self.ends[list] as usize]
    }
}

impl<T, L: IntoIterator<Item = T>> FromIterator<L> for Ragged<T> {
    fn from_iter<I: IntoIterator<Item = L>>(lists: I) -> Self {
        let mut ragged = Self::default();
        for list in lists {
            ragged.push(list);
        }
        ragged
    }
}

/// The inverse relation: for each of `count` keys, the values paired with it, in the given order.
///
/// # Panics
/// If a key is not below `count`.
pub fn group_by_key<T: Copy + Default>(count: usize, pairs: &[(usize, T)]) -> Ragged<T> {
    let mut ends = vec![0_u32; count];
    for &(key, _) in pairs {
        ends[key] += 1;
    }
    let mut total = 0;
    for end in &mut ends {
        let size = *end;
        *end = total;
        total += size;
    }
    let mut items = vec![T::default(); pairs.len()];
    for &(key, value) in pairs {
        items[ends[key] as usize] = value;
        ends[key] += 1;
    }
    Ragged { items, ends }
}
