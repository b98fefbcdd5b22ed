//! Extra columns whose kind shows only in their values.

use crate::rows::Rows;

/// Most extra columns. Columns need memory for every row, even if few rows have a value.
const MOST: usize = 64;

/// An extra column. It holds numbers until a row has a word.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Extra {
    name: String,
    kind: Option<Kind>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Numbers(usize),
    Words(usize),
}

impl Extra {
    pub(crate) fn new(name: &str) -> Self {
        Self { name: name.to_owned(), kind: None }
    }

    /// Sets the value of the last row to a number.
    pub(crate) fn set_number(&mut self, rows: &mut Rows, number: f64) {
        match *self.kind.get_or_insert_with(|| Kind::Numbers(rows.add_numbers(&self.name))) {
            Kind::Numbers(column) => rows.set_number(column, number),
            Kind::Words(column) => rows.set_word(column, &number.to_string()),
        }
    }

    /// Sets the value of the last row to a word.
    pub(crate) fn set_word(&mut self, rows: &mut Rows, word: &str) {
        let column = match self.kind {
            None => rows.add_words(&self.name),
            Some(Kind::Numbers(column)) => rows.words_of_numbers(column),
            Some(Kind::Words(column)) => column,
        };
        self.kind = Some(Kind::Words(column));
        rows.set_word(column, word);
    }

    fn has_words(&self) -> bool {
        matches!(self.kind, Some(Kind::Words(_)))
    }

    /// Sets the value of the last row to the number that a text is, or to the text as a word.
    pub(crate) fn set_text(&mut self, rows: &mut Rows, text: &str) {
        self.set(rows, text, text.parse().unwrap_or(f64::NAN));
    }

    /// Sets the value of the last row to a number, or to its text as a word if it is not finite or
    /// the column has words.
    pub(crate) fn set(&mut self, rows: &mut Rows, text: &str, number: f64) {
        if number.is_finite() && !self.has_words() {
            self.set_number(rows, number);
        } else {
            self.set_word(rows, text);
        }
    }
}

/// Extra columns that a file names row by row, or in its header.
#[derive(Default)]
pub(crate) struct Extras {
    columns: Vec<Extra>,
    /// Likely index of the next name: rows mostly have the same order.
    likely: usize,
}

impl Extras {
    /// Returns the index of the column with a name; nothing if there are too many, with a warning.
    pub(crate) fn index(&mut self, name: &str, rows: &mut Rows) -> Option<usize> {
        let likely = self.likely;
        let is_likely = self.columns.get(likely).is_some_and(|column| column.name == name);
        let known = || self.columns.iter().position(|column| column.name == name);
        let index = if is_likely { likely } else { known().unwrap_or(self.columns.len()) };
        if index >= MOST {
            rows.warnings.row(&format!("values beyond {MOST} extra columns were left out"), None);
            return None;
        }
        if index == self.columns.len() {
            self.columns.push(Extra::new(name));
        }
        self.likely = if index + 1 < self.columns.len() { index + 1 } else { 0 };
        Some(index)
    }

    /// Returns a column by its index.
    pub(crate) fn get(&mut self, index: usize) -> &mut Extra {
        &mut self.columns[index]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_beyond_the_most_are_left_out() {
        let (mut rows, mut extras) = (Rows::default(), Extras::default());
        let names: Vec<_> = (0..MOST + 1).map(|i| i.to_string()).collect();
        let index: Vec<_> = names.iter().map(|name| extras.index(name, &mut rows)).collect();
        assert_eq!(index[..MOST], (0..MOST).map(Some).collect::<Vec<_>>());
        assert_eq!(index[MOST], None);
        assert_eq!(extras.index("7", &mut rows), Some(7));
        assert_eq!(extras.index("8", &mut rows), Some(8));
        assert_eq!(rows.warnings.into_vec().len(), 1);
    }
}
