//! Reads time, position and effort of a log, and a second position if requested, row by row, into
//! bounded memory.
//!
//! At most [`MOST`] samples are kept. If a log has more, neighbours are averaged in pairs, as often
//! as needed: time, position and effort alike, so that linear relations between them hold. Rows are
//! numbered as in a spreadsheet: the header is row 1, blank lines and comments count, and a line
//! break inside quotes does not. A file in UTF-16 is decoded (`encoding.rs`).

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder};

use super::encoding;
use files::error::{Error, suggestion};

/// Largest number of samples: 24 MiB (32 with the motor), or an hour at 290 Hz.
pub const MOST: usize = 1 << 20;

/// Number of samples from which the resolution of the time is determined.
const LOOKED_AT: u64 = 10_000;

/// Least number of samples.
const FEWEST: usize = 100;

/// Placeholders that programs write for a missing number.
const MISSING: [&str; 8] = ["", "nan", "null", "na", "n/a", "none", "-", "inf"];

/// Columns to read: names in the header, or numbers from 1 in a file without one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogColumns {
    /// Time.
    pub time: String,
    /// Position.
    pub position: String,
    /// Effort.
    pub effort: String,
    /// Position of the motor, if the position is that of the load behind a gear; or its current.
    pub motor: Option<String>,
    /// Whether it is its current.
    pub has_motor_current: bool,
}

impl LogColumns {
    const fn motor_option(&self) -> &'static str {
        if self.has_motor_current { "--motor-current" } else { "--motor-position" }
    }
}

/// A log of time, position and effort, in the units of its file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionLog {
    /// Time of each sample; it never falls.
    pub time: Vec<f64>,
    /// Position of each sample.
    pub position: Vec<f64>,
    /// Effort of each sample.
    pub effort: Vec<f64>,
    /// Position of the motor at each sample, or its current; empty without its column.
    pub motor: Vec<f64>,
    /// Whether it is its current.
    pub has_motor_current: bool,
    /// Number of rows with all numbers.
    pub rows: u64,
    /// Number of rows that are averaged into a sample.
    pub folded: u64,
    /// Number of rows that lack a number.
    pub missing: u64,
    /// The first row that lacks a number.
    pub first_missing: Option<u64>,
    /// Number of rows with more cells than the first row of the file; they are skipped.
    pub long: u64,
    /// The first row with too many cells, and its number of cells.
    pub first_long: Option<(u64, usize)>,
    /// The first row with the same time as the row before.
    pub first_equal: Option<u64>,
    /// Resolution of the written times.
    pub time_digit: f64,
    /// Smallest change of the position between two rows, except 0: one count of a counted position.
    pub smallest_change: f64,
    /// Smallest change of the motor's position between two rows, except 0; infinite without its
    /// column.
    pub smallest_motor_change: f64,
    /// Whether a row of units below the header was left out.
    pub has_units_row: bool,
}

/// Reads the columns of a file.
///
/// # Errors
/// Returns an error with the file, the column or row, the value found and the allowed values.
pub fn read(path: &Path, columns: &LogColumns) -> Result<MotionLog, Error> {
    let name = path.display().to_string();
    let file = File::open(path).map_err(|source| Error::File {
        action: "read",
        path: path.into(),
        source,
    })?;
    read_from(&name, file, columns)
}

/// Reads the columns of a text; `name` is its name in errors.
///
/// # Errors
/// As [`read`].
pub fn read_from(name: &str, text: impl Read, columns: &LogColumns) -> Result<MotionLog, Error> {
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
        // The record's own position includes the blank lines and comments before it.
        inside += record.as_slice().iter().filter(|byte| **byte == b'\n').count() as u64;
        let row = reader.position().line() - 1 - inside;
        let Some(found) = &places else {
            let header: Vec<String> = record.iter().map(word).collect();
            // A first row of numbers, some of which may be missing, is data.
            let has_names = record.iter().any(|cell| samples.number(cell).is_err());
            let found = places_of(columns, &header, has_names).map_err(refuse)?;
            samples.width = header.len();
            if !has_names {
                samples.add(&record, row, &found, columns).map_err(refuse)?;
            }
            places = Some(found);
            continue;
        };
        samples.add(&record, row, found, columns).map_err(refuse)?;
    }
    samples.finish().map_err(refuse)
}

/// Creates a log from the samples of a program: time, position and effort, of the same length. The
/// resolution of the times is that of their shortest decimals. Rows are numbered from 1; a number
/// that is not finite is missing.
///
/// # Errors
/// Returns a sentence with the row and the value found, or with the lengths if they differ.
pub fn of_series([time, position, effort]: [&[f64]; 3]) -> Result<MotionLog, String> {
    let lengths = [time.len(), position.len(), effort.len()];
    if lengths != [time.len(); 3] {
        let [time, position, effort] = lengths;
        return Err(format!(
            "there are {time} times, {position} positions and {effort} efforts; there must be the \
             same number of each"
        ));
    }
    let rows = time.iter().zip(position).zip(effort);
    of_rows(rows.map(|((time, position), effort)| [*time, *position, *effort]))
}

/// Creates a log from rows: time, position, effort, and the motor's position if there is one. As
/// [`of_series`].
///
/// # Errors
/// Returns a sentence with the row and the value found.
pub fn of_rows<const N: usize>(rows: impl Iterator<Item = [f64; N]>) -> Result<MotionLog, String> {
    let mut samples = Samples::new(b',');
    for (place, row) in rows.enumerate() {
        let numbers = row.map(|one| one.is_finite().then_some(one));
        let digit = || row.first().map_or(0.0, |time| last_digit(time.to_string().as_bytes()));
        samples.push(&numbers, place as u64 + 1, digit)?;
    }
    samples.finish()
}

/// Text in which every line ends with a line feed, also the last one: the reader counts line feeds.
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

/// Returns the most frequent of semicolon, tab and comma in the first line that is not a comment; a
/// comma if there is none. A comma between two digits does not count, since it can be a decimal
/// comma; neither does a semicolon at the end.
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

/// Number of columns that are read: time, position, effort, and the motor's position if requested.
const COLUMNS: usize = 4;

/// Returns the indices of the columns in a row.
fn places_of(
    columns: &LogColumns,
    header: &[String],
    has_names: bool,
) -> Result<Vec<usize>, String> {
    let place = |option: &str, column: &str| {
        if !has_names {
            let number = column.parse::<usize>().ok();
            return number.filter(|n| (1..=header.len()).contains(n)).map(|n| n - 1).ok_or_else(
                || {
                    format!(
                        "{option} is `{column}`, but the file has no header; it must be the \
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
    let mut found = vec![
        place("--time", &columns.time)?,
        place("--position", &columns.position)?,
        place("--effort", &columns.effort)?,
    ];
    if let Some(motor) = &columns.motor {
        found.push(place(columns.motor_option(), motor)?);
    }
    let different: BTreeSet<usize> = found.iter().copied().collect();
    if different.len() < found.len() {
        let options = if found.len() == COLUMNS {
            format!("two of --time, --position, --effort and {}", columns.motor_option())
        } else {
            "two of --time, --position and --effort".into()
        };
        return Err(format!("{options} name the same column; each needs its own"));
    }
    Ok(found)
}

fn positions(header: &[String], is: impl Fn(&str) -> bool) -> Vec<usize> {
    header.iter().enumerate().filter(|(_, name)| is(name)).map(|(place, _)| place).collect()
}

/// Samples read so far.
struct Samples {
    log: MotionLog,
    delimiter: u8,
    /// Number of cells in the first row.
    width: usize,
    /// Number of rows that decimal commas seem to have split.
    parted: u64,
    /// Sums over the rows of the current sample.
    sums: [f64; COLUMNS],
    summed: u64,
    /// Time, position, and the motor's position of the row before.
    former: Option<[f64; 3]>,
}

impl Samples {
    fn new(delimiter: u8) -> Self {
        let log = MotionLog {
            folded: 1,
            time_digit: 1.0,
            smallest_change: f64::INFINITY,
            smallest_motor_change: f64::INFINITY,
            ..MotionLog::default()
        };
        Self { log, delimiter, width: 0, parted: 0, sums: [0.0; COLUMNS], summed: 0, former: None }
    }

    /// Parses a number; `None` if it is missing.
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
        places: &[usize],
        columns: &LogColumns,
    ) -> Result<(), String> {
        if self.is_long(record, row)? {
            return Ok(());
        }
        let mut numbers = [None; COLUMNS];
        let names = [&columns.time, &columns.position, &columns.effort];
        let names = names.into_iter().chain(&columns.motor);
        for ((place, name), number) in places.iter().zip(names).zip(&mut numbers) {
            let cell = record.get(*place).unwrap_or_default();
            *number = match self.number(cell) {
                Ok(number) => number,
                Err(()) if self.log.rows + self.log.missing == 0 && !self.log.has_units_row => {
                    self.log.has_units_row = true;
                    return Ok(());
                }
                Err(()) => {
                    return Err(format!(
                        "row {row}: `{}` in column `{name}` is not a number; leave a missing \
                         number empty, or write NaN",
                        word(cell)
                    ));
                }
            };
        }
        let time = places.first().and_then(|place| record.get(*place)).unwrap_or_default();
        self.push(&numbers[..places.len()], row, || last_digit(time))
    }

    /// Adds the numbers of a row; `digit` returns the value of the last digit of its time.
    ///
    /// # Errors
    /// Returns an error if the time falls.
    fn push(
        &mut self,
        numbers: &[Option<f64>],
        row: u64,
        digit: impl Fn() -> f64,
    ) -> Result<(), String> {
        let ([Some(time), Some(position), Some(_)]
        | [Some(time), Some(position), Some(_), Some(_)]) = *numbers
        else {
            self.log.missing += 1;
            self.log.first_missing.get_or_insert(row);
            return Ok(());
        };
        if self.log.rows < LOOKED_AT {
            self.log.time_digit = self.log.time_digit.min(digit());
        }
        let motor = numbers.get(3).copied().flatten().unwrap_or(0.0);
        if let Some([before, there, motor_there]) = self.former {
            if time < before {
                return Err(format!(
                    "row {row}: the time {time} follows {before}, but times must increase: sort \
                     the rows, cut the log where it restarts, or unwrap a counter that has \
                     overflowed"
                ));
            }
            if time == before {
                self.log.first_equal.get_or_insert(row);
            }
            let log = &mut self.log;
            for (smallest, change) in [
                (&mut log.smallest_change, position - there),
                (&mut log.smallest_motor_change, motor - motor_there),
            ] {
                if change != 0.0 {
                    *smallest = smallest.min(change.abs());
                }
            }
        }
        self.former = Some([time, position, motor]);
        self.log.rows += 1;
        for (sum, number) in self.sums.iter_mut().zip(numbers.iter().flatten()) {
            *sum += number;
        }
        self.summed += 1;
        if self.summed == self.log.folded {
            let of = self.summed as f64;
            self.log.time.push(self.sums[0] / of);
            self.log.position.push(self.sums[1] / of);
            self.log.effort.push(self.sums[2] / of);
            if numbers.len() == COLUMNS {
                self.log.motor.push(self.sums[3] / of);
            }
            (self.sums, self.summed) = ([0.0; COLUMNS], 0);
            if self.log.time.len() == MOST {
                fold(&mut self.log);
            }
        }
        Ok(())
    }

    /// Returns whether a row has more cells than the first row, and counts it. Empty cells at its
    /// end do not count.
    ///
    /// # Errors
    /// Returns an error if commas separate both columns and decimals.
    fn is_long(&mut self, record: &ByteRecord, row: u64) -> Result<bool, String> {
        let cells = record.iter().rposition(|cell| !cell.trim_ascii().is_empty());
        let cells = cells.map_or(0, |last| last + 1);
        if self.delimiter == b',' && row_of_decimals(record, self.width) {
            self.parted += 1;
            let others = self.log.rows + self.log.missing + self.log.long;
            if self.parted >= PARTED && 2 * self.parted > others {
                return Err(format!(
                    "row {row} has {cells} cells, but the first row {}: commas separate both \
                     columns and decimals, so the numbers are ambiguous; write decimals with a \
                     point, or separate the columns with semicolons or tabs",
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

    fn finish(self) -> Result<MotionLog, String> {
        let log = self.log;
        if let Some((first, cells)) = log.first_long.filter(|_| 10 * log.long > log.rows) {
            return Err(format!(
                "{} of {} rows have more cells than the first row of the file (row {first} has \
                 {cells}, the first row {}); at most a tenth of the rows may: name each column, or \
                 remove the rows",
                log.long,
                log.rows + log.missing + log.long,
                self.width
            ));
        }
        if log.time.len() < FEWEST {
            return Err(format!(
                "only {} rows have all numbers, at least {FEWEST} are needed: log some \
                 seconds of motion both ways",
                log.rows
            ));
        }
        // A log with more gaps is not usable.
        if let Some(first) = log.first_missing.filter(|_| 10 * log.missing > log.rows) {
            return Err(format!(
                "{} of {} rows lack a number (the first is row {first}); at most a tenth of the \
                 rows may: remove them, or name other columns",
                log.missing,
                log.rows + log.missing
            ));
        }
        Ok(log)
    }
}

/// Least number of rows with split decimals that shows a wrong separator, if most rows are split.
const PARTED: u64 = 3;

/// Returns whether decimal commas seem to have split a row of numbers: all its cells are whole
/// numbers, and either it has more cells than the first row (up to twice as many), or a cell has a
/// leading zero, as the second part of `0,05`.
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

/// Replaces pairs of neighbours by their mean.
fn fold(log: &mut MotionLog) {
    for series in [&mut log.time, &mut log.position, &mut log.effort, &mut log.motor] {
        for place in 0..series.len() / 2 {
            series[place] = 0.5 * (series[2 * place] + series[2 * place + 1]);
        }
        series.truncate(series.len() / 2);
    }
    log.folded *= 2;
}

/// Returns the value of the last digit of a written number.
fn last_digit(cell: &[u8]) -> f64 {
    let text = std::str::from_utf8(cell).unwrap_or_default().trim();
    let (digits, exponent) = text.split_once(['e', 'E']).unwrap_or((text, "0"));
    let behind = digits.split_once(['.', ',']).map_or(0, |(_, behind)| behind.len());
    let power = exponent.parse::<i32>().unwrap_or(0) - i32::try_from(behind).unwrap_or(0);
    10f64.powi(power)
}
