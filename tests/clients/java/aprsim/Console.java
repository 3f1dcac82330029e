package aprsim;

import java.io.BufferedReader;
import java.io.InputStreamReader;
import java.nio.charset.StandardCharsets;
import java.util.Arrays;
import java.util.concurrent.Future;
import java.util.function.Supplier;

/** A driver's ear and mouth: one command a line on standard input, "@ ..." lines as answers among the controller's own output. */
public final class Console {
  public interface Handler {
    /** Does one command; what it returns, unless null, is its answer. */
    String run(String command, String[] arguments) throws Exception;
  }

  public static synchronized void say(String text) {
    System.out.println("@ " + text.replace('\n', ' '));
    System.out.flush();
  }

  /** Runs until "quit" or the end of the input, and then ends the process. */
  public static void serve(Handler handler) throws Exception {
    BufferedReader in = new BufferedReader(new InputStreamReader(System.in, StandardCharsets.UTF_8));
    say("ready");
    for (String line; (line = in.readLine()) != null && !line.equals("quit"); ) {
      String[] words = line.trim().split(" +");
      try {
        String answer = handler.run(words[0], Arrays.copyOfRange(words, 1, words.length));
        if (answer != null) say(words[0] + " " + answer);
      } catch (Throwable fault) {
        fault.printStackTrace();
        say(words[0] + " failed: " + reason(fault));
      }
    }
    Runtime.getRuntime().halt(0);
  }

  /** Says "NAME ended true" or false once there is a result, with what there is to tell then. */
  public static void follow(String name, Future<Boolean> result, Supplier<String> remark) {
    new Thread(
            () -> {
              String end;
              try {
                end = String.valueOf(result.get());
              } catch (Throwable fault) {
                fault.printStackTrace();
                end = "false " + reason(fault);
              }
              say(name + " ended " + end + " " + remark.get());
            })
        .start();
  }

  /** The innermost cause, in one line. */
  public static String reason(Throwable fault) {
    while (fault.getCause() != null) fault = fault.getCause();
    String text = String.valueOf(fault.getMessage());
    return fault.getClass().getSimpleName() + ": " + text.substring(0, Math.min(300, text.length()));
  }
}
