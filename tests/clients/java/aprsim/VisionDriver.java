package aprsim;

import aprs.database.PhysicalItem;
import aprs.database.vision.VisionSocketClient;
import crcl.utils.XFutureVoid;
import java.util.List;
import java.util.Map;
import java.util.concurrent.LinkedBlockingQueue;
import java.util.concurrent.TimeUnit;

/** The framework's vision client. connect PORT; look N: how many things each of the next N lines holds. */
public final class VisionDriver {
  public static void main(String[] unused) throws Exception {
    VisionSocketClient client = new VisionSocketClient();
    LinkedBlockingQueue<List<PhysicalItem>> lists = new LinkedBlockingQueue<>(1000);
    client.addListener(
        (list, line, ignored) -> {
          if (!ignored && list != null) lists.offer(list);
          return XFutureVoid.completedFuture();
        });
    Console.serve(
        (command, arguments) -> {
          switch (command) {
            case "connect":
              client.start(Map.of("--visionhost", "localhost", "--visionport", arguments[0]));
              return "true";
            case "look":
              StringBuilder counts = new StringBuilder();
              for (int i = 0; i < Integer.parseInt(arguments[0]); ++i) {
                List<PhysicalItem> list = lists.poll(10, TimeUnit.SECONDS);
                if (list == null) return "nothing within 10 s";
                counts.append(list.size()).append(' ');
              }
              return counts.toString();
            default:
              throw new IllegalArgumentException(command);
          }
        });
  }
}
