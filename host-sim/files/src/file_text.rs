//! Edits of a file's text in place: everything else stays, comments included.

use toml_edit::{DocumentMut, Item, Table};

/// Sets a number under a path of tables and a key; the comment on its line stays. A table that is
/// missing is added at the end.
pub fn put_number(text: &mut DocumentMut, tables: &[&str], key: &str, number: f64) {
    let mut item = text.as_item_mut();
    for table in tables {
        let Some(within) = item.as_table_like_mut() else { return };
        item = within.entry(table).or_insert_with(|| Item::Table(Table::new()));
    }
    let Some(table) = item.as_table_like_mut() else { return };
    if let Some(old) = table.get_mut(key).and_then(Item::as_value_mut) {
        let decor = old.decor().clone();
        *old = number.into();
        *old.decor_mut() = decor;
    } else {
        table.insert(key, toml_edit::value(number));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_is_replaced_in_its_line_and_a_new_one_goes_to_the_end_of_its_table() {
        let mut text: DocumentMut =
            "a = 1 # one\n\n[b.c]\nd = 2   # two\n".parse().unwrap_or_default();
        put_number(&mut text, &["b", "c"], "d", 2.5);
        put_number(&mut text, &["b", "c"], "e", 3.0);
        put_number(&mut text, &["f"], "g", 4.0);
        // What is no table stays.
        put_number(&mut text, &["a"], "h", 5.0);
        let edited = "a = 1 # one\n\n[b.c]\nd = 2.5   # two\ne = 3.0\n\n[f]\ng = 4.0\n";
        assert_eq!(text.to_string(), edited);
    }
}
