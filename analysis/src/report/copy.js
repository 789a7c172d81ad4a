document.querySelectorAll("div.table").forEach(function (box) {
  var button = document.createElement("button");
  button.type = "button";
  button.textContent = "Copy";
  button.title = "Copy this table for a spreadsheet";
  button.addEventListener("click", function () {
    var text = Array.from(box.querySelectorAll("tr"), function (row) {
      return Array.from(row.cells, function (cell) {
        return (cell.dataset.v || cell.textContent).replace(/\s+/g, " ").trim();
      }).join("\t");
    }).join("\n");
    var done = function () {
      button.textContent = "Copied";
      setTimeout(function () { button.textContent = "Copy"; }, 1500);
    };
    var byHand = function () {
      var area = document.createElement("textarea");
      area.value = text;
      document.body.appendChild(area);
      area.select();
      if (document.execCommand("copy")) { done(); }
      area.remove();
    };
    if (navigator.clipboard) { navigator.clipboard.writeText(text).then(done, byHand); } else { byHand(); }
  });
  box.insertBefore(button, box.firstChild);
});
