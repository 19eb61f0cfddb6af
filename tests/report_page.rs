//! The report is one HTML file that opens anywhere and asks for nothing else.

use canloop::report::{Badge, Chart, Column, Figure, Page, Section, Series, Table};
use roxmltree::{Document, Node, ParsingOptions};

fn track(name: &str) -> Chart {
    let points = |radius: f64| -> Vec<(f64, f64)> {
        (0..=30_000)
            .map(|nth| std::f64::consts::TAU * f64::from(nth) / 30_000.0)
            .map(|angle| (5.0 + radius * libm::cos(angle), 5.0 + radius * libm::sin(3.0 * angle)))
            .collect()
    };
    Chart::new(name)
        .x_axis("x", "m")
        .y_axis("y", "m")
        .series(Series::reference(points(4.0)))
        .series(Series::response(points(3.9)))
}

fn table() -> Table {
    Table::new([Column::text("controller"), Column::number("error, max", "m", 3), Column::text("verdict")])
        .row(["adaptive".into(), 0.0042.into(), Badge::Pass.into()])
        .row(["PI <& friends>".into(), 1.2e45.into(), Badge::Diverges.into()])
}

fn page(figures: usize) -> String {
    let sections = (0..figures).map(|nth| {
        let charts = ["x", "y", "heading", "track"].map(track).to_vec();
        Section::new(format!("Part {nth}")).figure(Figure::new(format!("Figure {nth}"), "Both lines.", charts))
    });
    let summary = Section::new("Summary").paragraph("All is <b>well</b> & good.").table(table());
    let page = Page::new("A circle & more").lead("What this is.").section(summary).footer("canloop 0.1.0");
    sections.fold(page, Page::section).to_html()
}

fn parse(html: &str) -> Document<'_> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    Document::parse_with_options(html, options).unwrap_or_else(|problem| panic!("{problem} in\n{html}"))
}

fn elements<'a>(document: &'a Document, name: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    document.descendants().filter(move |node| node.tag_name().name() == name)
}

fn all_text(node: Node) -> String {
    node.descendants()
        .filter(Node::is_text)
        .filter_map(|text| text.text())
        .map(str::trim)
        .collect::<Vec<_>>()
        .join(" ")
        .trim()
        .to_owned()
}

#[test]
fn the_page_refers_to_nothing_outside_itself() {
    let html = page(2);
    let document = parse(&html);
    for node in document.descendants() {
        assert!(!["script", "link", "img", "iframe", "object", "image", "use"].contains(&node.tag_name().name()));
        for attribute in node.attributes() {
            let refers = ["href", "src", "srcset", "data", "action", "poster"].contains(&attribute.name());
            assert!(!refers || attribute.value().starts_with('#'), "{}={:?}", attribute.name(), attribute.value());
            assert!(!attribute.name().starts_with("on"), "{} is a script", attribute.name());
        }
    }
    for style in elements(&document, "style").map(all_text) {
        assert!(!style.contains("url(") && !style.contains("@import") && !style.contains("http"));
    }
}

#[test]
fn links_of_the_contents_lead_to_sections() {
    let html = page(3);
    let document = parse(&html);
    let links: Vec<_> = elements(&document, "a").filter_map(|link| link.attribute("href")).collect();
    assert_eq!(links.len(), 4);
    for link in links {
        assert!(
            document.descendants().any(|node| node.attribute("id") == link.strip_prefix('#')),
            "{link} leads nowhere"
        );
    }
    assert!(!page(1).contains("<nav"), "two sections need no list");
}

#[test]
fn prose_and_cells_are_plain_text() {
    let html = page(0);
    let document = parse(&html);
    assert!(elements(&document, "p").any(|node| all_text(node) == "All is <b>well</b> & good."));
    assert!(elements(&document, "td").any(|node| all_text(node) == "PI <& friends>"));
    assert_eq!(elements(&document, "h1").map(all_text).collect::<Vec<_>>(), ["A circle & more"]);
    assert_eq!(elements(&document, "footer").map(all_text).collect::<Vec<_>>(), ["canloop 0.1.0"]);
}

#[test]
fn a_table_shows_units_numbers_and_verdicts() {
    let html = page(0);
    let document = parse(&html);
    let heads: Vec<_> = elements(&document, "th").map(all_text).collect();
    assert_eq!(heads, ["controller", "error, max (m)", "verdict"]);
    let cells: Vec<_> = elements(&document, "td").map(all_text).collect();
    assert_eq!(cells, ["adaptive", "0.004", "✓\u{a0}pass", "PI <& friends>", "1.20×10⁴⁵", "↗\u{a0}diverges"]);
}

#[test]
fn sentences_may_take_several_lines_where_other_cells_may_not() {
    let table = Table::new([Column::text("a"), Column::prose("b")]).row(["word".into(), "A sentence.".into()]);
    let html = Page::new("Title").section(Section::new("Part").table(table)).to_html();
    let document = parse(&html);
    let classes: Vec<_> = elements(&document, "td").filter_map(|cell| cell.attribute("class")).collect();
    assert_eq!(classes, ["words", "prose"]);
    assert!(html.contains("td.prose { white-space: normal;"));
}

#[test]
fn thirty_two_charts_share_one_style_sheet_and_stay_small() {
    let html = page(8);
    let document = parse(&html);
    assert_eq!(elements(&document, "style").count(), 1);
    assert_eq!(elements(&document, "svg").filter(|node| node.attribute("role") == Some("img")).count(), 32);
    assert!(html.len() < 300_000, "{} bytes", html.len());
}

#[test]
fn the_same_page_is_the_same_bytes() {
    assert_eq!(page(1), page(1));
}
