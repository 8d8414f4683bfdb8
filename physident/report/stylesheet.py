"""How the page looks: one column on a phone, two of charts on a desk, nothing cut in two on paper."""

STYLE = """
:root { color-scheme: light; --ink: #1a1a1a; --soft: #5a5a5a; --line: #d9d9d9; --ground: #f5f5f3; }
* { box-sizing: border-box; }
body { margin: 0; color: var(--ink); background: #fff; font: 16px/1.5 system-ui, "Segoe UI", "DejaVu Sans", sans-serif;
  -webkit-print-color-adjust: exact; print-color-adjust: exact; overflow-wrap: break-word; }
main { max-width: 104rem; margin: 0 auto; padding: 1.5rem 1rem 3rem; }
h1 { font-size: clamp(1.5rem, 1.1rem + 1.8vw, 2.3rem); line-height: 1.2; margin: .3rem 0 .8rem; }
h2 { font-size: 1.3rem; margin: 2.5rem 0 .6rem; border-bottom: 2px solid var(--ink); padding-bottom: .2rem; }
h3 { font-size: 1.05rem; margin: 1.2rem 0 .4rem; }
p, ul { max-width: 50rem; margin: .5rem 0; }
header { display: grid; grid-template-columns: 1fr minmax(14rem, 24rem); gap: 1rem 3rem; align-items: start; }
.practice { list-style: none; padding: .2rem 1rem; border-left: .3rem solid #0072B2; background: #eef4f9; font-size: 1.12rem; }
.practice li { margin: .3rem 0; }
.arm { break-inside: avoid; }
.arm svg { display: block; width: 100%; max-height: 24rem; }
.arm p { margin: .1rem 0; }
.arm .link { stroke: #a9a9a9; stroke-width: 13; stroke-linecap: round; vector-effect: none; }
.arm .foot { fill: #6e6e6e; }
.arm text { text-anchor: middle; font-size: 14px; fill: var(--soft); }
.arm text.marked { fill: var(--ink); font-weight: 700; }
.cards { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 40rem), 1fr)); gap: 1rem 1.5rem; align-items: start; }
.cards article { margin: 0; min-width: 0; }
.lead { font-size: 1.12rem; }
.mark { color: var(--soft); margin: 0; }
.mark b { color: #fff; background: #5a5a5a; border-radius: .8rem; padding: .1rem .7rem; margin-left: .4rem; white-space: nowrap; }
.mark b.explained, .mark b.nothing_missing { background: #00663f; }
.mark b.partly_explained { background: #8a5a00; }
.mark b.unexplained { background: #a03a00; }
.caution { border-left: .3rem solid #E69F00; background: #fff7e6; padding: .4rem .8rem; }
.fine, small { color: var(--soft); font-size: .85rem; }
pre { margin: .4rem 0; padding: .4rem .6rem; background: var(--ground); overflow-x: auto; }
code { font: .85em ui-monospace, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; }
article { border-left: .4rem solid; background: var(--ground); padding: .2rem 1rem .6rem; margin: 1rem 0; break-inside: avoid; }
article h3 { margin-top: .5rem; }
.wide { overflow-x: auto; margin: .6rem 0; }
table { border-collapse: collapse; font-size: .92rem; }
th, td { text-align: left; vertical-align: top; padding: .25rem .9rem .25rem 0; border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 600; }
table.numbers td { font-variant-numeric: tabular-nums; }
table.files { width: 100%; }
table.files td:first-child { min-width: 8rem; }
ul.grid { max-width: none; list-style: none; padding: 0; display: grid; gap: .2rem 1.5rem;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 21rem), 1fr)); }
.legend span { margin-right: 1.2rem; white-space: nowrap; }
.legend i, td i { display: inline-block; width: 1.4rem; height: .3rem; margin-right: .4rem; vertical-align: middle; }
.level { display: grid; grid-template-columns: 14rem 1fr 7rem 19rem; gap: .2rem 1rem; align-items: center;
  padding: .4rem 0; border-bottom: 1px solid var(--line); break-inside: avoid; }
.level .cell { font-variant-numeric: tabular-nums; }
.bar { height: .55rem; margin: .15rem 0; background: #ececec; }
.bar i { display: block; height: 100%; }
.joints { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 27rem), 1fr)); gap: 1.2rem 2rem; }
figure { margin: 0; break-inside: avoid; }
figcaption { font-size: .92rem; margin-bottom: .2rem; }
.chart { display: grid; grid-template-columns: 3.6rem 1fr; font-size: .78rem; color: var(--soft); margin-bottom: .3rem; }
.chart .title { grid-column: 2; }
.chart .rows { position: relative; }
.chart .rows span { position: absolute; right: .4rem; transform: translateY(-50%); }
.chart .area { height: 9rem; border-left: 1px solid var(--ink); border-bottom: 1px solid var(--ink); }
.chart svg { display: block; width: 100%; height: 100%; }
.columns { position: relative; height: 1.3em; }
.chart .columns { grid-column: 2; }
.columns span { position: absolute; transform: translateX(-50%); }
.below { text-align: right; font-size: .78rem; color: var(--soft); }
.chart .below { grid-column: 2; }
polyline { fill: none; vector-effect: non-scaling-stroke; stroke-linejoin: round; }
line { stroke: #e2e2e2; vector-effect: non-scaling-stroke; }
line.zero { stroke: #9a9a9a; }
rect.band { fill: #e4e4ef; }
.scale { margin: 1rem 0; font-size: .78rem; color: var(--soft); }
.scale .marks { position: relative; height: 2rem; border-bottom: 1px solid var(--ink); }
.marks u { position: absolute; top: 0; bottom: 0; border-left: 2px dashed var(--ink); }
.marks b { position: absolute; top: .2rem; transform: translateX(-50%); font-weight: 400; color: var(--soft); font-size: 1.1rem; }
.marks i { position: absolute; top: .5rem; width: 1rem; height: 1rem; border-radius: 50%; transform: translateX(-50%);
  border: 1px solid #fff; }
.scale .threshold { color: var(--ink); font-weight: 600; }
@media (max-width: 60rem) {
  header { grid-template-columns: 1fr; }
  .arm { max-width: 22rem; }
  .level { grid-template-columns: 6.5rem 1fr; }
  .level .name, .level .bars { grid-column: 1 / -1; }
}
@media (max-width: 36rem) {
  table, tbody, td { display: block; width: 100%; }
  thead { display: none; }
  tr { display: flex; flex-wrap: wrap; gap: 0 1rem; border-bottom: 1px solid var(--line); padding: .4rem 0; }
  td { border: 0; padding: .05rem 0; }
  table.numbers td { width: auto; }
  td:not(:first-child)::before { content: attr(data-label) " "; color: var(--soft); font-size: .85rem; }
}
@page { margin: 14mm 14mm 18mm; @bottom-right { content: counter(page) " / " counter(pages); font: 9pt sans-serif; color: #5a5a5a; } }
@media print {
  body { font-size: 10.5pt; }
  main { max-width: none; padding: 0; }
  h2, h3, h3 + p, .legend, thead { break-after: avoid; }
  tr, li, figure, .scale, .caution, .practice, pre { break-inside: avoid; }
  header { grid-template-columns: 1fr 15rem; gap: 1rem; }
  h1 { font-size: 1.4rem; }
  .lead, .practice { font-size: 1em; }
  .levels { break-inside: avoid; }
  .cards { display: block; }
  .cards article { margin: 0 0 1rem; }
  p { orphans: 3; widows: 3; }
  .level { grid-template-columns: 10rem 1fr 6rem 16rem; font-size: 9.5pt; }
  .level .name, .level .bars { grid-column: auto; }
  .joints { grid-template-columns: 1fr 1fr; gap: .8rem 1.2rem; }
  .chart .area { height: 6.5rem; }
  .wide { overflow: visible; break-inside: avoid; }
  .wide:has(table.files) { break-inside: auto; }
  pre { overflow: visible; white-space: pre-wrap; }
}
"""
