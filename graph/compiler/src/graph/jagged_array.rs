//! Lists of different lengths, one after another in one piece of memory.
//!
//! Most passes and resources have one or two entries in each list. A vector of vectors would put each of these lists
//! somewhere else in memory, and a graph of 10,000 passes would be a walk over all of it.

/// An array of lists of different lengths, stored in one allocation. Indexing with a row number returns the list.
#[derive(Clone, Debug)]
pub(crate) struct JaggedArray<T> {
    items: Vec<T>,
    /// The end of each list, as an index into `items`.
    ends: Vec<u32>,
}

impl<T> JaggedArray<T> {
    pub(crate) fn with_capacity(rows: usize, items: usize) -> Self {
        Self { items: Vec::with_capacity(items), ends: Vec::with_capacity(rows) }
    }

    /// Adds the next list.
    pub(crate) fn push(&mut self, row: impl IntoIterator<Item = T>) {
        self.items.extend(row);
        self.ends.push(self.items.len() as u32);
    }

    /// The number of lists.
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The items of all lists, one list after another.
    pub(crate) fn items(&self) -> &[T] {
        &self.items
    }
}

impl<T> std::ops::Index<usize> for JaggedArray<T> {
    type Output = [T];

    fn index(&self, row: usize) -> &[T] {
        let start = row.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.items[start as usize..self.ends[row] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::JaggedArray;

    #[test]
    fn lists_stay_apart() {
        let mut rows = JaggedArray::with_capacity(3, 3);
        rows.push([1, 2]);
        rows.push([]);
        rows.push([3]);
        assert_eq!((&rows[0], &rows[1], &rows[2]), (&[1, 2][..], &[][..], &[3][..]));
        assert_eq!((rows.len(), rows.items()), (3, &[1, 2, 3][..]));
    }
}
