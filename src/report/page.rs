//! One HTML page that holds all it needs.

use super::chart::Chart;
use super::heat_map::HeatMap;
use super::markup::Markup;
use super::svg;
use super::table::Table;

/// The page may use its own style sheet and nothing else, on any host.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'";
/// From so many sections on, the page begins with a list of them.
const SECTIONS_WORTH_LISTING: usize = 3;

/// A page: title, lead, sections, footer. All text is plain text.
#[derive(Clone, Debug, Default)]
pub struct Page {
    title: String,
    lead: String,
    sections: Vec<Section>,
    footer: String,
}

/// A part of a page with a heading of its own.
#[derive(Clone, Debug)]
pub struct Section {
    heading: String,
    blocks: Vec<Block>,
}

/// Charts side by side, with a caption.
#[derive(Clone, Debug)]
pub struct Figure {
    name: String,
    caption: String,
    charts: Vec<Chart>,
}

#[derive(Clone, Debug)]
enum Block {
    Paragraph(String),
    Table(Table),
    Figure(Figure),
    Map(HeatMap),
}

impl Page {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), ..Self::default() }
    }

    /// Says in a paragraph what the page is about.
    pub fn lead(mut self, text: impl Into<String>) -> Self {
        self.lead = text.into();
        self
    }

    /// Adds a section.
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// Says at the end what made the page, with its version.
    pub fn footer(mut self, text: impl Into<String>) -> Self {
        self.footer = text.into();
        self
    }

    /// The page as an HTML file that opens without a network.
    pub fn to_html(&self) -> String {
        let mut out = Markup::default();
        out.trusted("<!DOCTYPE html>\n");
        out.open("html", &[("lang", "en")]);
        self.write_head(&mut out);
        out.open("body", &[]);
        out.open("header", &[]);
        out.leaf("h1", &[], &self.title);
        if !self.lead.is_empty() {
            out.leaf("p", &[("class", "lead")], &self.lead);
        }
        out.close("header");
        self.write_contents(&mut out);
        out.open("main", &[]);
        for (nth, section) in self.sections.iter().enumerate() {
            section.write(&anchor(nth), &mut out);
        }
        out.close("main");
        if !self.footer.is_empty() {
            out.leaf("footer", &[], &self.footer);
        }
        out.close("body");
        out.close("html");
        out.finish()
    }

    fn write_head(&self, out: &mut Markup) {
        out.open("head", &[]);
        out.empty("meta", &[("charset", "utf-8")]);
        out.empty("meta", &[("http-equiv", "Content-Security-Policy"), ("content", POLICY)]);
        out.empty("meta", &[("name", "viewport"), ("content", "width=device-width, initial-scale=1")]);
        out.empty("meta", &[("name", "color-scheme"), ("content", "light dark")]);
        out.leaf("title", &[], &self.title);
        out.trusted("<style>\n");
        out.trusted(include_str!("page.css"));
        out.trusted(include_str!("chart.css"));
        if self.sections.iter().any(Section::has_map) {
            out.trusted(include_str!("heat_map.css"));
        }
        out.trusted("</style>\n");
        out.close("head");
    }

    fn write_contents(&self, out: &mut Markup) {
        if self.sections.len() < SECTIONS_WORTH_LISTING {
            return;
        }
        out.open("nav", &[("aria-label", "Contents")]);
        out.open("ol", &[]);
        for (nth, section) in self.sections.iter().enumerate() {
            out.open("li", &[]);
            out.leaf("a", &[("href", &format!("#{}", anchor(nth)))], &section.heading);
            out.close("li");
        }
        out.close("ol");
        out.close("nav");
    }
}

impl Section {
    /// A section without content.
    pub fn new(heading: impl Into<String>) -> Self {
        Self { heading: heading.into(), blocks: Vec::new() }
    }

    /// Adds a paragraph.
    pub fn paragraph(self, text: impl Into<String>) -> Self {
        self.block(Block::Paragraph(text.into()))
    }

    /// Adds a table.
    pub fn table(self, table: Table) -> Self {
        self.block(Block::Table(table))
    }

    /// Adds a figure.
    pub fn figure(self, figure: Figure) -> Self {
        self.block(Block::Figure(figure))
    }

    /// Adds a map.
    pub fn map(self, map: HeatMap) -> Self {
        self.block(Block::Map(map))
    }

    fn has_map(&self) -> bool {
        self.blocks.iter().any(|block| matches!(block, Block::Map(_)))
    }

    fn block(mut self, block: Block) -> Self {
        self.blocks.push(block);
        self
    }

    fn write(&self, anchor: &str, out: &mut Markup) {
        out.open("section", &[("id", anchor)]);
        out.leaf("h2", &[], &self.heading);
        for block in &self.blocks {
            match block {
                Block::Paragraph(text) => out.leaf("p", &[], text),
                Block::Table(table) => table.write(out),
                Block::Figure(figure) => figure.write(out),
                Block::Map(map) => {
                    out.open("figure", &[]);
                    map.write(out, None);
                    out.close("figure");
                }
            }
        }
        out.close("section");
    }
}

impl Figure {
    /// `charts` two by two (one by one on a narrow screen) over
    /// "**name.** caption".
    pub fn new(name: impl Into<String>, caption: impl Into<String>, charts: Vec<Chart>) -> Self {
        Self { name: name.into(), caption: caption.into(), charts }
    }

    fn write(&self, out: &mut Markup) {
        out.open("figure", &[]);
        out.open("div", &[("class", "charts")]);
        for chart in &self.charts {
            svg::draw(chart, out, None);
        }
        out.close("div");
        out.open("figcaption", &[]);
        out.leaf("b", &[], &format!("{}.", self.name));
        out.text(&self.caption);
        out.close("figcaption");
        out.close("figure");
    }
}

fn anchor(nth_section: usize) -> String {
    format!("section-{}", nth_section + 1)
}
