//! Reads time, position and effort of a log, row by row, into bounded memory.
//!
//! At most [`MOST`] samples are kept. Where a log has more, neighbours are averaged in pairs, as
//! often as it takes: the same average over time, position and effort, so that what is linear
//! between them stays as it is. A row counts as in a spreadsheet: the header is row 1, blank lines
//! and comments count, and a break inside quotes does not. A file in UTF-16 is decoded
//! (`encoding.rs`).

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder};

use super::encoding;
use crate::error::{Error, suggestion};

/// So many samples are kept: 24 MiB, and an hour at 290 Hz.
pub const MOST: usize = 1 << 20;

/// Samples that tell how finely time is written.
const LOOKED_AT: u64 = 10_000;

/// Fewer samples tell nothing.
const FEWEST: usize = 100;

/// What some programs write where they have no number.
const MISSING: [&str; 8] = ["", "nan", "null", "na", "n/a", "none", "-", "inf"];

/// The columns to read, by their names in the header; by their numbers from 1 if there is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns {
    /// Time.
    pub time: String,
    /// Position.
    pub position: String,
    /// Effort.
    pub effort: String,
}

/// What a log holds, in the units of its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Log {
    /// Time of each sample; it never falls.
    pub time: Vec<f64>,
    /// Position of each sample.
    pub position: Vec<f64>,
    /// Effort of each sample.
    pub effort: Vec<f64>,
    /// Rows with three numbers.
    pub rows: u64,
    /// Rows that one sample is the mean of.
    pub folded: u64,
    /// Rows that lack a number, and the first of them.
    pub missing: u64,
    /// The first row that lacks a number.
    pub first_missing: Option<u64>,
    /// Rows with more cells than the first row of the file, which were left out.
    pub long: u64,
    /// The first of them, and how many cells it has.
    pub first_long: Option<(u64, usize)>,
    /// The first row whose time is that of the row before.
    pub first_equal: Option<u64>,
    /// What the last digit of a time stands for.
    pub time_digit: f64,
    /// The smallest change of the position from row to row that is not 0: a count, if the position
    /// is counted.
    pub smallest_change: f64,
    /// Whether a row of units below the header was left out.
    pub has_units_row: bool,
}

/// Reads the columns of a file.
///
/// # Errors
/// Names the file and the column or the row, what was found and what is allowed.
pub fn read(path: &Path, columns: &Columns) -> Result<Log, Error> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|source| Error::File {
        action: "read",
        path: path.into(),
        source,
    })?;
    read_from(&name, file, columns)
}

/// Reads the columns of a text that is named so.
///
/// # Errors
/// As [`read`].
pub fn read_from(name: &str, text: impl Read, columns: &Columns) -> Result<Log, Error> {
    let refuse = |why: String| Error::Input(format!("{name}: {why}"));
    let failed = |source| Error::File { action: "read", path: name.into(), source };
    let text = encoding::decoded(text).map_err(failed)?;
    let mut text = BufReader::with_capacity(1 << 16, Lines::new(text));
    let begin = text.fill_buf().map_err(failed)?;
    if encoding::has_no_mark(begin) {
        return Err(refuse(encoding::NO_MARK.into()));
    }
    let has_mark = begin.starts_with(b"\xEF\xBB\xBF");
    let delimiter = delimiter(if has_mark { &begin[3..] } else { begin });
    if has_mark {
        text.consume(3);
    }
    let mut reader = ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .from_reader(text);
    let mut record = ByteRecord::new();
    let mut places = None;
    let mut samples = Samples::new(delimiter);
    let mut inside = 0;
    while reader.read_byte_record(&mut record).map_err(|error| refuse(error.to_string()))? {
        // The position of the record itself is that of the blank lines and comments before it.
        inside += record.as_slice().iter().filter(|byte| **byte == b'\n').count() as u64;
        let row = reader.position().line() - 1 - inside;
        let Some(found) = places else {
            let header: Vec<String> = record.iter().map(word).collect();
            // A first row of numbers, some of which may be missing, is data.
            let has_names = record.iter().any(|cell| samples.number(cell).is_err());
            let found = places_of(columns, &header, has_names).map_err(refuse)?;
            samples.width = header.len();
            places = Some(found);
            if !has_names {
                samples.add(&record, row, found, columns).map_err(refuse)?;
            }
            continue;
        };
        samples.add(&record, row, found, columns).map_err(refuse)?;
    }
    samples.finish().map_err(refuse)
}

/// Lines that end with a line feed each, the last one too, however the file ends them: the reader
/// counts line feeds.
struct Lines<R> {
    text: BufReader<R>,
    last: u8,
    is_return: bool,
}

impl<R: Read> Lines<R> {
    fn new(text: R) -> Self {
        Self { text: BufReader::with_capacity(1 << 16, text), last: b'\n', is_return: false }
    }
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        loop {
            let found = self.text.fill_buf()?;
            let (read, mut written) = (found.len().min(into.len()), 0);
            if read == 0 {
                let is_open = self.last != b'\n' && !into.is_empty();
                if is_open {
                    into[0] = b'\n';
                    self.last = b'\n';
                }
                return Ok(usize::from(is_open));
            }
            for byte in &found[..read] {
                // The line feed after a carriage return has been written already.
                if !(*byte == b'\n' && self.is_return) {
                    self.last = if *byte == b'\r' { b'\n' } else { *byte };
                    into[written] = self.last;
                    written += 1;
                }
                self.is_return = *byte == b'\r';
            }
            self.text.consume(read);
            if written > 0 {
                return Ok(written);
            }
        }
    }
}

/// The byte that stands most often in the first line that is no comment; a comma, if none does.
/// Neither a comma between two digits counts, which may be a decimal's, nor a semicolon at the end.
fn delimiter(begin: &[u8]) -> u8 {
    let lines = begin.split(|byte| *byte == b'\n');
    let first = lines.into_iter().find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let line = first.unwrap_or_default().trim_ascii_end();
    let line = line.strip_suffix(b";").unwrap_or(line);
    let digit =
        |place: Option<usize>| place.and_then(|i| line.get(i)).is_some_and(u8::is_ascii_digit);
    let is_decimal =
        |i: usize| line[i] == b',' && digit(i.checked_sub(1)) && digit(i.checked_add(1));
    let count = |of: u8| (0..line.len()).filter(|i| line[*i] == of && !is_decimal(*i)).count();
    [b';', b'\t', b','].into_iter().max_by_key(|of| count(*of)).unwrap_or(b',')
}

fn word(cell: &[u8]) -> String {
    String::from_utf8_lossy(cell).trim().to_owned()
}

/// Where the three columns stand.
fn places_of(columns: &Columns, header: &[String], has_names: bool) -> Result<[usize; 3], String> {
    let place = |option: &str, column: &str| {
        if !has_names {
            let number = column.parse::<usize>().ok();
            return number.filter(|n| (1..=header.len()).contains(n)).map(|n| n - 1).ok_or_else(
                || {
                    format!(
                        "{option} is `{column}`, but the file has no header; allowed is the \
                         number of a column, from 1 to {}",
                        header.len()
                    )
                },
            );
        }
        let exact: Vec<usize> = positions(header, |name| name == column.trim());
        let like = positions(header, |name| name.eq_ignore_ascii_case(column.trim()));
        match (&exact[..], &like[..]) {
            ([one], _) | ([], [one]) => Ok(*one),
            ([], []) => Err(format!(
                "{option}: there is no column `{column}`{}",
                suggestion(column, header.iter().map(String::as_str))
            )),
            _ => Err(format!("{option}: more than one column is called `{column}`; rename one")),
        }
    };
    let found = [
        place("--time", &columns.time)?,
        place("--position", &columns.position)?,
        place("--effort", &columns.effort)?,
    ];
    let [time, position, effort] = found;
    if time == position || time == effort || position == effort {
        return Err("two of --time, --position and --effort name the same column; allowed are \
                    three"
            .into());
    }
    Ok(found)
}

fn positions(header: &[String], is: impl Fn(&str) -> bool) -> Vec<usize> {
    header.iter().enumerate().filter(|(_, name)| is(name)).map(|(place, _)| place).collect()
}

/// What has been read so far.
struct Samples {
    log: Log,
    delimiter: u8,
    /// Cells of the first row.
    width: usize,
    /// Rows of numbers that the commas of decimals may have parted, among the first ones.
    parted: u64,
    /// Sums of the sample that is being made, and how many rows they are of.
    sums: [f64; 3],
    summed: u64,
    former: Option<[f64; 2]>,
}

impl Samples {
    fn new(delimiter: u8) -> Self {
        let log =
            Log { folded: 1, time_digit: 1.0, smallest_change: f64::INFINITY, ..Log::default() };
        Self { log, delimiter, width: 0, parted: 0, sums: [0.0; 3], summed: 0, former: None }
    }

    /// A number; none where it is missing.
    fn number(&self, cell: &[u8]) -> Result<Option<f64>, ()> {
        let text = std::str::from_utf8(cell).map_err(|_| ())?.trim();
        let read = match text.parse::<f64>() {
            Err(_) if self.delimiter != b',' => text.replace(',', ".").parse(),
            read => read,
        };
        match read {
            Ok(number) => Ok(number.is_finite().then_some(number)),
            Err(_) if MISSING.iter().any(|word| text.eq_ignore_ascii_case(word)) => Ok(None),
            Err(_) => Err(()),
        }
    }

    fn add(
        &mut self,
        record: &ByteRecord,
        row: u64,
        places: [usize; 3],
        columns: &Columns,
    ) -> Result<(), String> {
        if self.is_long(record, row)? {
            return Ok(());
        }
        let mut numbers = [None; 3];
        let names = [&columns.time, &columns.position, &columns.effort];
        for ((place, name), number) in places.into_iter().zip(names).zip(&mut numbers) {
            let cell = record.get(place).unwrap_or_default();
            *number = match self.number(cell) {
                Ok(number) => number,
                Err(()) if self.log.rows + self.log.missing == 0 && !self.log.has_units_row => {
                    self.log.has_units_row = true;
                    return Ok(());
                }
                Err(()) => {
                    return Err(format!(
                        "row {row}: `{}` in column `{name}` is no number; allowed are numbers, \
                         and nothing or NaN where one is missing",
                        word(cell)
                    ));
                }
            };
        }
        let [Some(time), Some(position), Some(effort)] = numbers else {
            self.log.missing += 1;
            self.log.first_missing.get_or_insert(row);
            return Ok(());
        };
        if self.log.rows < LOOKED_AT {
            let digit = last_digit(record.get(places[0]).unwrap_or_default());
            self.log.time_digit = self.log.time_digit.min(digit);
        }
        if let Some([before, there]) = self.former {
            if time < before {
                return Err(format!(
                    "row {row}: the time {time} comes after {before}; times have to increase: sort \
                     the rows, cut the log where it begins again, or unwrap a counter that has \
                     run over"
                ));
            }
            if time == before {
                self.log.first_equal.get_or_insert(row);
            }
            let change = (position - there).abs();
            if change > 0.0 && change < self.log.smallest_change {
                self.log.smallest_change = change;
            }
        }
        self.former = Some([time, position]);
        self.log.rows += 1;
        self.sums = [self.sums[0] + time, self.sums[1] + position, self.sums[2] + effort];
        self.summed += 1;
        if self.summed == self.log.folded {
            let of = self.summed as f64;
            self.log.time.push(self.sums[0] / of);
            self.log.position.push(self.sums[1] / of);
            self.log.effort.push(self.sums[2] / of);
            (self.sums, self.summed) = ([0.0; 3], 0);
            if self.log.time.len() == MOST {
                fold(&mut self.log);
            }
        }
        Ok(())
    }

    /// Counts a row that has more cells than the first row; empty ones at its end do not count.
    ///
    /// # Errors
    /// If commas separate the columns and the decimals alike.
    fn is_long(&mut self, record: &ByteRecord, row: u64) -> Result<bool, String> {
        let cells = record.iter().rposition(|cell| !cell.trim_ascii().is_empty());
        let cells = cells.map_or(0, |last| last + 1);
        if self.delimiter == b',' && row_of_decimals(record, self.width) {
            self.parted += 1;
            let others = self.log.rows + self.log.missing + self.log.long;
            if self.parted >= PARTED && 2 * self.parted > others {
                return Err(format!(
                    "row {row} has {cells} cells, and the first row {}: a comma separates the \
                     columns and the decimals alike, so no cell can be known; write decimals with \
                     a point, or separate the columns with semicolons or tabs",
                    self.width
                ));
            }
        }
        if cells <= self.width {
            return Ok(false);
        }
        self.log.long += 1;
        self.log.first_long.get_or_insert((row, cells));
        Ok(true)
    }

    fn finish(self) -> Result<Log, String> {
        let log = self.log;
        if let Some((first, cells)) = log.first_long.filter(|_| 10 * log.long > log.rows) {
            return Err(format!(
                "{} of {} rows have more cells than the first row of the file: the first is row \
                 {first} with {cells}, and that has {}; allowed is a tenth: name each column, or \
                 drop the rows",
                log.long,
                log.rows + log.missing + log.long,
                self.width
            ));
        }
        if log.time.len() < FEWEST {
            return Err(format!(
                "{} rows have all three numbers; at least {FEWEST} are needed, and some seconds of \
                 motion both ways",
                log.rows
            ));
        }
        // More holes than this are no log of a motion.
        if let Some(first) = log.first_missing.filter(|_| 10 * log.missing > log.rows) {
            return Err(format!(
                "{} of {} rows lack a number, the first is row {first}; allowed is a tenth: drop \
                 them, or name other columns",
                log.missing,
                log.rows + log.missing
            ));
        }
        Ok(log)
    }
}

/// Rows of decimal commas between commas that are enough to know them, if they are most rows.
const PARTED: u64 = 3;

/// Whether the commas of decimals may have parted a row of numbers: all cells are whole numbers,
/// and either they are more than the columns and at most two for each, or one begins with a zero
/// that no whole number has, as in `0,05`.
fn row_of_decimals(record: &ByteRecord, width: usize) -> bool {
    let cells: Vec<&str> =
        record.iter().map(|cell| std::str::from_utf8(cell).unwrap_or_default().trim()).collect();
    let is_whole = |cell: &&str| !cell.contains('.') && cell.parse::<f64>().is_ok();
    if !cells.iter().all(is_whole) {
        return false;
    }
    let has_zero = cells.iter().any(|cell| cell.len() > 1 && cell.starts_with('0'));
    has_zero || (width + 1..=2 * width).contains(&cells.len())
}

/// Averages pairs of neighbours.
fn fold(log: &mut Log) {
    for series in [&mut log.time, &mut log.position, &mut log.effort] {
        for place in 0..series.len() / 2 {
            series[place] = 0.5 * (series[2 * place] + series[2 * place + 1]);
        }
        series.truncate(series.len() / 2);
    }
    log.folded *= 2;
}

/// What the last digit of a number stands for.
fn last_digit(cell: &[u8]) -> f64 {
    let text = std::str::from_utf8(cell).unwrap_or_default().trim();
    let (digits, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let behind = digits.split_once(['.', ',']).map_or(0, |(_, behind)| behind.len());
    let power = exponent.parse::<i32>().unwrap_or(0) - i32::try_from(behind).unwrap_or(0);
    10f64.powi(power)
}
