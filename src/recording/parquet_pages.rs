//! Pages of a Parquet column, looked at before they are decoded: the decoder takes their order for granted.

use parquet::basic::Encoding;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::ColumnChunkMetaData;

/// Whether the bytes that a column is said to have lie in a file of this length: the reader takes it for granted.
pub(super) fn lies_inside(column: &ColumnChunkMetaData, file_bytes: u64) -> bool {
    let start = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
    let (start, length) = (u64::try_from(start).ok(), u64::try_from(column.compressed_size()).ok());
    let end = start.zip(length).and_then(|(start, length)| start.checked_add(length));
    end.is_some_and(|end| end <= file_bytes) && column.data_page_offset() >= 0 && column.num_values() >= 0
}

/// Pages of which none is by a dictionary before there is one, and none follows it as a second dictionary.
pub(super) struct SoundPages {
    pages: Box<dyn PageReader>,
    has_dictionary: bool,
}

impl SoundPages {
    /// The pages of a column.
    pub(super) fn of(pages: Box<dyn PageReader>) -> Self {
        Self { pages, has_dictionary: false }
    }

    fn checked(&mut self, page: Page) -> Result<Page> {
        let refuse = |words: &str| Err(ParquetError::General(words.to_owned()));
        let by_dictionary = matches!(page.encoding(), Encoding::RLE_DICTIONARY | Encoding::PLAIN_DICTIONARY);
        match page {
            Page::DictionaryPage { .. } if self.has_dictionary => refuse("a second dictionary in a column"),
            Page::DictionaryPage { .. } => {
                self.has_dictionary = true;
                Ok(page)
            }
            _ if by_dictionary && !self.has_dictionary => refuse("values by a dictionary that is not there"),
            _ => Ok(page),
        }
    }
}

impl PageReader for SoundPages {
    fn get_next_page(&mut self) -> Result<Option<Page>> {
        let page = self.pages.get_next_page()?;
        page.map(|page| self.checked(page)).transpose()
    }

    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>> {
        self.pages.peek_next_page()
    }

    fn skip_next_page(&mut self) -> Result<()> {
        self.pages.skip_next_page()
    }
}

impl Iterator for SoundPages {
    type Item = Result<Page>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}
