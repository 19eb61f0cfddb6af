//! The cells of a column of a Parquet file, until they are written.

use std::str::FromStr;

use parquet::basic::{LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::writer::SerializedColumnWriter;
use parquet::schema::types::Type;

use super::{Column, Kind};

/// A column and those of its cells that wait.
pub struct Cells {
    column: Column,
    values: Values,
    /// For each cell whether there is a value: 1 or 0.
    filled: Vec<i16>,
}

/// The values of cells that are not empty.
enum Values {
    Whole(Vec<i64>),
    Number(Vec<f64>),
    Truth(Vec<bool>),
    Words(Vec<ByteArray>),
}

impl Cells {
    /// None yet.
    pub fn new(column: Column) -> Self {
        let values = match column.kind {
            Kind::Whole => Values::Whole(Vec::new()),
            Kind::Number => Values::Number(Vec::new()),
            Kind::Truth => Values::Truth(Vec::new()),
            Kind::Words => Values::Words(Vec::new()),
        };
        Self { column, values, filled: Vec::new() }
    }

    /// The column's name.
    pub fn name(&self) -> &str {
        &self.column.name
    }

    /// The column in Parquet's words.
    ///
    /// # Errors
    /// There is no such column.
    pub fn field(&self) -> Result<Type, ParquetError> {
        let (physical, logical) = match self.column.kind {
            Kind::Whole => (PhysicalType::INT64, None),
            Kind::Number => (PhysicalType::DOUBLE, None),
            Kind::Truth => (PhysicalType::BOOLEAN, None),
            Kind::Words => (PhysicalType::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let repetition = if self.column.may_be_empty { Repetition::OPTIONAL } else { Repetition::REQUIRED };
        let field = Type::primitive_type_builder(self.name(), physical).with_logical_type(logical);
        field.with_repetition(repetition).build()
    }

    /// Takes a cell.
    ///
    /// # Errors
    /// It is not of the column's kind.
    pub fn push(&mut self, cell: &str) -> Result<(), String> {
        let is_filled = !(self.column.may_be_empty && cell.is_empty());
        self.filled.push(is_filled.into());
        if !is_filled {
            return Ok(());
        }
        let pushed = match &mut self.values {
            Values::Whole(values) => push(values, cell).ok_or("a whole number"),
            Values::Number(values) => push(values, cell).ok_or("a number"),
            Values::Truth(values) => push(values, cell).ok_or("true or false"),
            Values::Words(values) => {
                values.push(cell.into());
                Ok(())
            }
        };
        pushed.map_err(|expected| format!("found {cell:?} in the column {}, expected {expected}", self.name()))
    }

    /// Hands over all cells; then there are none.
    ///
    /// # Errors
    /// There is no room.
    pub fn write(&mut self, mut writer: SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        let filled = self.column.may_be_empty.then_some(&self.filled[..]);
        match &mut self.values {
            Values::Whole(values) => write_all::<Int64Type>(&mut writer, values, filled)?,
            Values::Number(values) => write_all::<DoubleType>(&mut writer, values, filled)?,
            Values::Truth(values) => write_all::<BoolType>(&mut writer, values, filled)?,
            Values::Words(values) => write_all::<ByteArrayType>(&mut writer, values, filled)?,
        }
        self.filled.clear();
        writer.close()
    }
}

fn write_all<T: DataType>(
    writer: &mut SerializedColumnWriter<'_>,
    values: &mut Vec<T::T>,
    filled: Option<&[i16]>,
) -> Result<(), ParquetError> {
    writer.typed::<T>().write_batch(values, filled, None)?;
    values.clear();
    Ok(())
}

fn push<T: FromStr>(values: &mut Vec<T>, cell: &str) -> Option<()> {
    values.push(cell.parse().ok()?);
    Some(())
}
