//! A chart is a well-formed, self-sufficient SVG picture, whatever it is given.

use canloop::report::{Chart, Role, Series, Stroke};
use roxmltree::{Document, Node};

const SPOTS: usize = 150_000;

fn over_time(value: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
    (0..=SPOTS).map(|nth| nth as f64 / 1000.0).map(|time_s| (time_s, value(time_s))).collect()
}

fn circle() -> Vec<(f64, f64)> {
    (0..=SPOTS)
        .map(|nth| std::f64::consts::TAU * nth as f64 / SPOTS as f64)
        .map(|angle| (5.0 + 4.0 * libm::cos(angle), 5.0 + 4.0 * libm::sin(angle)))
        .collect()
}

fn chart(points: Vec<(f64, f64)>) -> Chart {
    Chart::new("Position x").x_axis("time", "s").y_axis("x", "m").series(Series::response(points))
}

/// The class that the drawn lines of `role` carry, without the legend's sample.
fn line<'a>(document: &'a Document, role: &str) -> &'a str {
    let in_plot = |node: &Node| node.parent_element().is_some_and(|parent| parent.attribute("overflow").is_some());
    let of_role = |node: &Node| node.attribute("class").is_some_and(|class| class.ends_with(role));
    document
        .descendants()
        .find(|node| in_plot(node) && of_role(node))
        .and_then(|node| node.attribute("d"))
        .unwrap_or("")
}

fn points_px(path: &str) -> Vec<(f64, f64)> {
    let numbers: Vec<f64> =
        path.split(['M', ' ']).filter(|word| !word.is_empty()).map(|word| word.parse().unwrap()).collect();
    numbers.chunks(2).map(|pair| (pair[0], pair[1])).collect()
}

/// The middle of the box that holds all points.
fn middle(points: &[(f64, f64)]) -> (f64, f64) {
    let centre = |values: Vec<f64>| {
        0.5 * (values.iter().copied().fold(f64::MIN, f64::max) + values.iter().copied().fold(f64::MAX, f64::min))
    };
    (centre(points.iter().map(|point| point.0).collect()), centre(points.iter().map(|point| point.1).collect()))
}

fn texts(document: &Document) -> Vec<String> {
    document.descendants().filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "text"))).map(words).collect()
}

fn words(node: Node) -> String {
    node.text().unwrap_or("").to_owned()
}

#[test]
fn every_chart_is_well_formed_xml() {
    let ramp = vec![(0.0, 0.0), (1.0, 1.0)];
    let wild = vec![(0.0, f64::NAN), (f64::INFINITY, 1.0), (1.0, 1e308), (2.0, -1e308), (3.0, 1e299), (4.0, -1e299)];
    let charts = [
        Chart::default(),
        chart(vec![]),
        chart(vec![(0.0, f64::NAN)]),
        chart(vec![(0.0, 0.0)]),
        chart(vec![(0.0, 1e45); 3]).equal_aspect(),
        chart(over_time(|time_s| libm::exp(0.7 * time_s))),
        chart(wild.clone()),
        chart(wild).equal_aspect(),
        chart(ramp.clone()).x_range(f64::NAN, 1.0).y_range(2.0, 2.0),
        chart(ramp.clone()).x_range(1e-300, -1e300).y_range(1e200, 2e200),
        chart(ramp.clone()).limit("none", f64::NAN).marker("never", f64::INFINITY).x_band("", f64::NAN, 1.0),
        chart(ramp).x_band("on", 0.5, f64::INFINITY).y_band("upside down", 1.0, 0.0),
        Chart::new("</title><script>").x_axis("\0\u{1b}", "&").y_axis("\"", "'").marker("<", 0.5).limit("]]>", 0.1),
    ];
    for chart in charts {
        let svg = chart.to_svg();
        let document = Document::parse(&svg).unwrap_or_else(|problem| panic!("{problem} in\n{svg}"));
        let shapes = document.descendants().filter(|node| node.is_element() && !node.has_tag_name("desc"));
        for attribute in shapes.flat_map(|node| node.attributes()) {
            let value = attribute.value();
            assert!(!value.contains("NaN") && !value.contains("inf"), "{}={value:?}", attribute.name());
        }
    }
}

#[test]
fn texts_come_out_as_they_went_in() {
    let svg = Chart::new("x < y & \"z\"").x_axis("<time>", "s").y_axis("a & b", "").to_svg();
    let document = Document::parse(&svg).unwrap();
    let texts = texts(&document);
    for text in ["x < y & \"z\"", "<time> (s)", "a & b", "no data"] {
        assert!(texts.iter().any(|found| found == text), "{text:?} is not among {texts:?}");
    }
    let root = document.root_element();
    assert_eq!(root.attribute("role"), Some("img"));
    assert_eq!(root.first_element_child().map(words).as_deref(), Some("x < y & \"z\""));
}

#[test]
fn a_line_has_at_most_two_points_a_pixel_and_keeps_a_spike_of_one_sample() {
    let mut points = over_time(|time_s| libm::sin(1e5 * time_s * time_s));
    points[90_123].1 = 10.0;
    let svg = chart(points).to_svg();
    let drawn = points_px(line(&Document::parse(&svg).unwrap(), "response"));
    let width_px = drawn.last().unwrap().0;
    assert!(drawn.len() as f64 <= 2.0 * width_px + 4.0, "{} points on {width_px} px", drawn.len());
    let top = drawn.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    assert!((top.0 / width_px - 0.6008).abs() < 0.003, "the spike is at {top:?}");
    assert!(drawn.iter().filter(|point| point.1 < top.1 + 50.0).count() == 1);
}

#[test]
fn a_smooth_line_of_150_000_points_is_drawn_with_few() {
    let svg = chart(over_time(|time_s| libm::cos(time_s / 20.0))).to_svg();
    let drawn = points_px(line(&Document::parse(&svg).unwrap(), "response"));
    assert!((20..200).contains(&drawn.len()), "{} points", drawn.len());
}

#[test]
fn missing_numbers_interrupt_a_line() {
    let svg =
        chart(vec![(0.0, 0.0), (1.0, 1.0), (2.0, f64::NAN), (3.0, 1.0), (4.0, f64::INFINITY), (5.0, 0.0)]).to_svg();
    let document = Document::parse(&svg).unwrap();
    let pieces: Vec<_> = line(&document, "response").split('M').skip(1).map(|piece| points_px(piece).len()).collect();
    assert_eq!(pieces, [2, 2, 2], "a line, and two lone points drawn as dots");
}

#[test]
fn a_circle_is_round_whichever_axis_is_the_tighter_one() {
    for far in [(5.0, 5.0), (50.0, 5.0), (5.0, 50.0)] {
        let lone = Series::new("far", Role::Estimate, Stroke::Solid, vec![far]);
        let svg = chart(circle()).series(lone).equal_aspect().to_svg();
        let drawn = points_px(line(&Document::parse(&svg).unwrap(), "response"));
        let (centre, radius) = (middle(&drawn), (drawn[0].0 - drawn[drawn.len() / 2].0) / 2.0);
        assert!(radius > 10.0 && (20..400).contains(&drawn.len()), "{} points, radius {radius} px", drawn.len());
        for (x, y) in drawn {
            let off = ((x - centre.0) * (x - centre.0) + (y - centre.1) * (y - centre.1)).sqrt() - radius;
            assert!(off.abs() < 0.5, "with {far:?}, ({x}, {y}) is {off} px off the circle");
        }
    }
}

#[test]
fn a_dotted_reference_lies_above_the_response_it_coincides_with() {
    let points = vec![(0.0, 0.0), (1.0, 1.0)];
    let svg = Chart::new("").series(Series::reference(points.clone())).series(Series::response(points)).to_svg();
    let plot = &svg[svg.find("overflow").unwrap()..];
    assert!(plot.find("line solid response") < plot.find("line dotted reference"));
    assert!(svg.contains("reference</text>") && svg.contains("response</text>"), "the legend names both");
}

#[test]
fn diverging_numbers_share_one_power_of_ten_on_the_axis() {
    let svg = chart(vec![(0.0, 0.0), (1.0, 1e45)]).to_svg();
    let texts = texts(&Document::parse(&svg).unwrap());
    assert!(texts.contains(&"x (10⁴⁵ m)".to_owned()), "{texts:?}");
    assert!(texts.contains(&"0.8".to_owned()), "{texts:?}");
}

#[test]
fn the_y_axis_holds_limits_and_bands() {
    let of = |chart: Chart| texts(&Document::parse(&chart.to_svg()).unwrap());
    let torque = || chart(vec![(0.0, 0.0), (1.0, 1.0)]);
    assert!(!of(torque()).contains(&"−10".to_owned()));
    assert!(of(torque().limit("limit", 12.0).limit("limit", -12.0)).contains(&"−10".to_owned()));
    assert!(of(torque().y_band("tolerance", -12.0, 12.0)).contains(&"−10".to_owned()));
    let named = of(torque().limit("limit", 12.0).limit("limit", -12.0));
    assert_eq!(named.iter().filter(|text| *text == "limit").count(), 1, "one name, one entry in the legend");
}

#[test]
fn an_axis_of_words_has_no_numbers() {
    let states = chart(vec![(0.0, 0.0), (1.0, 1.0)]).y_range(-0.5, 1.5).y_words([(0.0, "off"), (1.0, "on")]);
    let svg = states.to_svg();
    let texts = texts(&Document::parse(&svg).unwrap());
    assert!(["off", "on"].iter().all(|word| texts.iter().any(|text| text == word)), "{texts:?}");
    assert!(!texts.iter().any(|text| text == "1.5"), "{texts:?}");
}

#[test]
fn marker_labels_give_way_to_each_other() {
    let crowd =
        (0..6).fold(chart(vec![(0.0, 0.0), (9.0, 1.0)]), |chart, nth| chart.marker(format!("event {nth}"), 5.0));
    let svg = crowd.to_svg();
    let document = Document::parse(&svg).unwrap();
    let labels = || document.descendants().filter(|node| node.attribute("class") == Some("event"));
    let mut rows: Vec<_> = labels().map(|label| label.attribute("y")).collect();
    rows.dedup();
    assert_eq!(rows.len(), 4, "as many rows as there may be, one label each");
    let lines: Vec<_> = document.descendants().filter(|node| node.attribute("class") == Some("marker")).collect();
    assert_eq!(lines.len(), 6);
    assert_eq!(lines[5].first_element_child().map(words).as_deref(), Some("event 5"), "its tool tip still tells");
}

#[test]
fn a_chart_brings_a_rule_for_each_class_and_colours_for_light_and_dark() {
    let points = || vec![(0.0, 0.0), (1.0, 1.0)];
    let svg = chart(points())
        .series(Series::reference(points()))
        .series(Series::new("odometry", Role::Estimate, Stroke::Dashed, points()))
        .series(Series::new("right", Role::Right, Stroke::Solid, points()))
        .series(Series::new("left", Role::Left, Stroke::Solid, points()))
        .limit("limit", 2.0)
        .marker("tripped", 0.5)
        .x_band("silent", 0.2, 0.3)
        .y_band("tolerance", 0.0, 0.5)
        .to_svg();
    let document = Document::parse(&svg).unwrap();
    let style = document.descendants().find(|node| node.tag_name().name() == "style").map(words).unwrap();
    assert!(style.contains("prefers-color-scheme: dark"));
    let classes = document.descendants().filter_map(|node| node.attribute("class")).flat_map(str::split_whitespace);
    // A solid stroke is what a line is without a rule.
    for class in classes.filter(|class| *class != "solid") {
        assert!(style.contains(&format!(".{class} ")), "no rule for {class}");
    }
}

#[test]
fn the_same_chart_is_the_same_bytes() {
    let draw = || chart(circle()).equal_aspect().to_svg();
    assert_eq!(draw(), draw());
    let svg = chart(vec![(0.0, 0.0), (1.0, 1.0 / 3.0), (3.0, 1.0)]).to_svg();
    assert_eq!(line(&Document::parse(&svg).unwrap(), "response"), "M0 194.73 362 9.27");
}
