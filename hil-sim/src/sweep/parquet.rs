//! Results as a Parquet file: the rows of the CSV file, in columns of their kinds.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use csv::StringRecord;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::{KeyValue, SortingColumn};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::cells::Cells;
use super::draft::Draft;
use super::rows::Rows;
use super::{Plan, columns};

/// A table being written; only when it is finished does it have its name.
pub struct Table {
    writer: SerializedFileWriter<File>,
    draft: Draft,
    columns: Vec<Cells>,
    /// Rows that wait for their group to be full.
    waiting: usize,
}

/// What bounds the rows in memory.
const GROUP_ROWS: usize = 50_000;

/// Writes the rows of the results of `plan` in the file `csv` to the Parquet
/// file `output`.
///
/// # Errors
/// What cannot be read, is no row of this plan, or cannot be written.
pub fn to_parquet(csv: &Path, output: &Path, plan: &Plan) -> Result<(), String> {
    let mut rows = Rows::open(csv)?;
    let mut table = Table::create(output, plan, &rows.header)?;
    let mut row = StringRecord::new();
    while rows.next(&mut row)? {
        table.put(&row)?;
    }
    table.finish()
}

impl Table {
    /// Begins the table of the results of `plan` at `path`. Its rows have the
    /// columns of `header`.
    ///
    /// # Errors
    /// These are not the columns of the plan, or nothing can be written there.
    pub fn create(path: &Path, plan: &Plan, header: &StringRecord) -> Result<Self, String> {
        let columns: Vec<Cells> = columns(&plan.axes).into_iter().map(Cells::new).collect();
        let expected: Vec<&str> = columns.iter().map(Cells::name).collect();
        if *header != expected {
            let found: Vec<&str> = header.iter().collect();
            return Err(format!(
                "cannot write {}: found the columns {}, expected {}; another version of this program wrote them",
                path.display(),
                found.join(","),
                expected.join(",")
            ));
        }
        let draft = Draft::of(path);
        let file = draft.create().map_err(|error| cannot(path, &error.into()))?;
        let writer = schema(&columns)
            .and_then(|schema| SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties(plan)?)));
        let writer = writer.map_err(|error| cannot(path, &error))?;
        Ok(Self { writer, draft, columns, waiting: 0 })
    }

    /// Appends a row.
    ///
    /// # Errors
    /// A cell is not of its column's kind, or there is no room.
    pub fn put(&mut self, row: &StringRecord) -> Result<(), String> {
        for (column, cell) in self.columns.iter_mut().zip(row) {
            column.push(cell).map_err(|what| format!("run {}: {what}", &row[0]))?;
        }
        self.waiting += 1;
        if self.waiting == GROUP_ROWS { self.put_group() } else { Ok(()) }
    }

    /// Writes what waits, and gives the file its name.
    ///
    /// # Errors
    /// There is no room.
    pub fn finish(mut self) -> Result<(), String> {
        if self.waiting > 0 {
            self.put_group()?;
        }
        let closed = self.writer.into_inner().and_then(|file| Ok(self.draft.publish(&file)?));
        closed.map_err(|error| cannot(&self.draft.path, &error))
    }

    fn put_group(&mut self) -> Result<(), String> {
        self.waiting = 0;
        let mut put = || {
            let mut group = self.writer.next_row_group()?;
            for column in &mut self.columns {
                // There are as many as the schema has.
                let Some(writer) = group.next_column()? else { break };
                column.write(writer)?;
            }
            group.close()
        };
        put().map(drop).map_err(|error| cannot(&self.draft.path, &error))
    }
}

fn schema(columns: &[Cells]) -> Result<Type, ParquetError> {
    let fields = columns.iter().map(|column| column.field().map(Arc::new)).collect::<Result<_, _>>()?;
    Type::group_type_builder("results").with_fields(fields).build()
}

fn properties(plan: &Plan) -> Result<WriterProperties, ParquetError> {
    let about = [("plan", plan.text.as_str()), ("program", "hil-sim"), ("version", env!("CARGO_PKG_VERSION"))];
    let about = about.map(|(key, value)| KeyValue::new(key.to_owned(), value.to_owned()));
    let by_run = SortingColumn { column_idx: 0, descending: false, nulls_first: false };
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
        .set_key_value_metadata(Some(about.into()))
        .set_sorting_columns(Some(vec![by_run]));
    Ok(properties.build())
}

/// Says what the system says, without the library's words for it.
fn cannot(path: &Path, error: &ParquetError) -> String {
    match error {
        ParquetError::External(error) => format!("cannot write {}: {error}", path.display()),
        error => format!("cannot write {}: {error}", path.display()),
    }
}
