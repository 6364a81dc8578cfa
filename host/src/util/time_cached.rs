//! A cache of items that are valid at one time only.

/// Items by number, each with the time at which it was stored. Memory is taken only for items that were stored once.
#[derive(Clone, Debug)]
pub(crate) struct TimeCached<T> {
    /// For each index the position of its item plus one; 0 if there is none.
    numbers: Vec<u32>,
    items: Vec<(u64, T)>,
}

impl<T> Default for TimeCached<T> {
    fn default() -> Self {
        Self {
            numbers: Vec::new(),
            items: Vec::new(),
        }
    }
}

impl<T> TimeCached<T> {
    fn number(&self, index: usize) -> Option<usize> {
        let number = self.numbers.get(index)?;
        (*number as usize).checked_sub(1)
    }

    /// Returns the item stored last, of whatever time.
    pub(crate) fn last(&self, index: usize) -> Option<&T> {
        self.number(index).map(|number| &self.items[number].1)
    }

    /// Returns the item if it was stored at this time.
    pub(crate) fn get(&self, index: usize, time: u64) -> Option<&T> {
        let (at, item) = &self.items[self.number(index)?];
        (*at == time).then_some(item)
    }

    /// Makes all items invalid: none is of the time `u64::MAX`.
    pub(crate) fn forget(&mut self) {
        for (time, _) in &mut self.items {
            *time = u64::MAX;
        }
    }

    /// Stores an item.
    pub(crate) fn set(&mut self, index: usize, time: u64, item: T) {
        if index >= self.numbers.len() {
            self.numbers.resize(index + 1, 0);
        }
        if let Some(number) = self.number(index) {
            self.items[number] = (time, item);
        } else {
            self.items.push((time, item));
            self.numbers[index] = u32::try_from(self.items.len()).unwrap_or(u32::MAX);
        }
    }
}
