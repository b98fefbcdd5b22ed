//! Extra columns whose kind shows only in their values.

use crate::rows::Rows;

/// An extra column. It holds numbers until a row has a word.
pub(crate) struct Extra {
    name: String,
    kind: Option<Kind>,
}

#[derive(Clone, Copy)]
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

    /// Sets the value of the last row to the number that a text is, or to the text as a word.
    pub(crate) fn set_text(&mut self, rows: &mut Rows, text: &str) {
        match text.parse() {
            Ok(number) => self.set_number(rows, number),
            Err(_) => self.set_word(rows, text),
        }
    }
}
