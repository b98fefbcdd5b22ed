//! Values that are kept once however many users they have.

use std::collections::HashMap;
use std::sync::Arc;

use populace_model::convert::u32_from;

/// Words that users have in common, each with a number and with what was made for it.
#[derive(Clone, Debug)]
pub(super) struct Interned<T> {
    numbers: HashMap<Arc<[u32]>, u32>,
    /// By number.
    entries: Vec<Entry<T>>,
    /// Numbers of no words.
    free: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Entry<T> {
    words: Arc<[u32]>,
    users: usize,
    made: T,
}

impl<T> Default for Interned<T> {
    fn default() -> Self {
        Self { numbers: HashMap::new(), entries: Vec::new(), free: Vec::new() }
    }
}

impl<T: Copy> Interned<T> {
    /// Counts one more user of words that somebody uses, and returns their number.
    pub(super) fn share(&mut self, words: &[u32]) -> Option<u32> {
        let number = *self.numbers.get(words)?;
        self.entries[number as usize].users += 1;
        Some(number)
    }

    /// Adds words that nobody uses, with one user, and returns their number.
    pub(super) fn add(&mut self, words: &[u32], made: T) -> u32 {
        let words: Arc<[u32]> = words.into();
        let entry = Entry { words: Arc::clone(&words), users: 1, made };
        let number = if let Some(number) = self.free.pop() {
            self.entries[number as usize] = entry;
            number
        } else {
            self.entries.push(entry);
            u32_from(self.entries.len() - 1)
        };
        self.numbers.insert(words, number);
        number
    }

    /// Returns what was made for the words with a number in use.
    pub(super) fn made(&self, number: u32) -> T {
        self.entries[number as usize].made
    }

    /// Counts one user less. Without a user left, the number is given to other words, and what was
    /// made is returned. Does nothing for
    /// [`NONE`](crate::layout::NONE).
    pub(super) fn release(&mut self, number: u32) -> Option<T> {
        let Entry { words, users, made } = self.entries.get_mut(number as usize)?;
        *users -= 1;
        if *users > 0 {
            return None;
        }
        self.numbers.remove(words);
        self.free.push(number);
        Some(*made)
    }
}

#[cfg(test)]
mod tests {
    use super::Interned;
    use crate::layout::NONE;

    #[test]
    fn equal_words_share_a_number_as_long_as_somebody_uses_it() {
        let mut all = Interned::default();
        assert_eq!(all.share(&[1, 2]), None);
        let (one, other) = (all.add(&[1, 2], 'a'), all.add(&[1], 'b'));
        assert_ne!(one, other);
        assert_eq!(all.share(&[1, 2]), Some(one));
        assert_eq!((all.made(one), all.made(other)), ('a', 'b'));
        assert_eq!(all.release(one), None);
        assert_eq!(all.share(&[1, 2]), Some(one));
        assert_eq!(all.release(one), None);
        assert_eq!(all.release(one), Some('a'));
        assert_eq!(all.share(&[1, 2]), None);
        assert_eq!(all.add(&[3], 'c'), one, "a number that nobody uses");
        assert_eq!(all.made(one), 'c');
        assert_eq!(all.release(NONE), None);
    }
}
